"""The command line: one short file per command with its options, one call into `commands`, and how it is shown.

typer and rich live here alone; nothing heavy is imported before a command runs.
"""
