"""Friction runs as `simulate` writes them."""
