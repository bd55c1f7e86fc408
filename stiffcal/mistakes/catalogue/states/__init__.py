"""Mistakes in load states: runs that are exchanged, and what went wrong inside a run."""
