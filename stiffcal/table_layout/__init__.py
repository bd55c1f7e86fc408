"""How a table of unknown make is written: its header, the names of its columns, its numbers."""
