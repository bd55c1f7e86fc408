"""Mistakes that show in what a fit leaves of absolute places, in the order in which they were measured."""
