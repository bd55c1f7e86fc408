"""Mistakes in the course of absolute places."""
