"""Types of what `diagnose` answers."""
