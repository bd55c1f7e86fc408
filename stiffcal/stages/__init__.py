"""The chain behind every command: what is stored, missing or stale, and how it is brought up to date."""
