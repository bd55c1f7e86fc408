"""When one of several distances decides: between what is measured and what a mistake taken back makes of it."""

MUCH_BETTER = 0.3
"""A change that explains a distance leaves less than this share of it. The right one leaves what the robot misses by
itself, millimetres where the mistake makes decimetres."""
AS_GOOD = 1.5
"""Changes that leave no more than so many times the least explain it alike. The median distance of ten rows is
known to a sixth, the ratio of two of them to a quarter: this is two standard errors."""
