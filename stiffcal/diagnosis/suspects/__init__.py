"""Runs and rows that disagree with all the others, looked for before any effect is."""
