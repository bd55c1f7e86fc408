"""Pictures of what each effect does to a robot."""
