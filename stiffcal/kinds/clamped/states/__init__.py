"""Clamped runs as load states: their noise, what is left out together."""
