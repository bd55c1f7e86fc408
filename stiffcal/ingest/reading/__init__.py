"""Runs read once: their readings, tables, texts and keys in the store."""
