"""Clamped runs as `simulate` writes them."""
