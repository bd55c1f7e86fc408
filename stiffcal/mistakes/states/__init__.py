"""Mistakes that are tried on what a model leaves of load states, next to effects that may be missing from it."""
