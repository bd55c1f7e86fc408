"""Mistakes in the clocks of a run's logs, which show in how one runs against another."""
