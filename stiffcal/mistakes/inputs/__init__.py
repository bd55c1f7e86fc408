"""Mistakes in what is read: in a table, the manifest or the robot file."""
