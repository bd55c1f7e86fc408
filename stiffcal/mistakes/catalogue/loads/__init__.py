"""Mistakes in loads and displacements: whom they act on, columns, signs, axes."""
