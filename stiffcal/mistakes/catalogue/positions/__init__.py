"""Mistakes in measured positions and orientations: units, columns, axes, targets."""
