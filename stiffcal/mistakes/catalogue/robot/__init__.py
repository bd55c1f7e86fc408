"""Mistakes in the robot file."""
