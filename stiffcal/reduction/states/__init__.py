"""Load states of logs and tables, and what each of them refers to."""
