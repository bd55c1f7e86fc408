"""Units of angles that are taken for each other."""

from __future__ import annotations

from math import pi

DEGREE_UNITS = (
    (180.0 / pi, "in rad in a column of degrees"),
    (pi / 180.0, "in degrees in a column of rad"),
)
ANGLE_UNITS = (
    (1e3, "in rad in a column of mrad"),
    (1e-3, "in mrad in a column of rad"),
    *DEGREE_UNITS,
)
"""By what angles are multiplied, and what they are then."""
