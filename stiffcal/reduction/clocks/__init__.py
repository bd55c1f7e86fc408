"""Offsets between the clocks of one run's logs, and how evenly they run."""
