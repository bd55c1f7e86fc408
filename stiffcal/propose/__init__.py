"""Drafts of what a person would write, from the files that are there: manifest, robot file, lines to copy."""
