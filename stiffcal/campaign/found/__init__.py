"""Formats of logs and kinds of experiment: found by walking their folders, never by import of one."""
