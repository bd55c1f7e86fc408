"""Mistakes in the frames of tracker and target."""
