"""A robot with effects at its places, their values, and the frames that a fit estimates with them."""
