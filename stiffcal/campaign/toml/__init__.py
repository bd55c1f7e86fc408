"""Reading a TOML file to types: syntax, names, reach, and what a person wrote wrongly in the lab's words."""
