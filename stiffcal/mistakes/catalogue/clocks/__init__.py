"""Mistakes in the clocks of a run's logs."""
