"""Rows that do not belong together."""
