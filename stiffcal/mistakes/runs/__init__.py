"""Mistakes in all readings of one run, taken back; a model that is fitted to the other runs decides."""
