"""Mistakes in single runs: units, signs, readings of another run."""
