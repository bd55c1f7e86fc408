"""Units in which forces and moments are logged where SI is expected, and the other way round."""

from __future__ import annotations

KGF, LBF = 9.80665, 4.4482216152605
"""N; kgf by the third General Conference on Weights and Measures (1901), lbf by the international pound of 1959."""
INCH, FOOT = 0.0254, 0.3048  # m

FORCE_UNITS = (
    ("kgf", KGF, 1.0 / KGF),
    ("lbf", LBF, 1.0 / LBF),
    ("kN", 1e3, 1e-3),
)
MOMENT_UNITS = (
    ("N·mm", 1e-3, 1e3),
    ("N·cm", 1e-2, 1e2),
    ("lbf·in", LBF * INCH, 1.0 / (LBF * INCH)),
    ("lbf·ft", LBF * FOOT, 1.0 / (LBF * FOOT)),
    ("kgf·m", KGF, 1.0 / KGF),
    ("kgf·cm", KGF * 1e-2, 1e2 / KGF),
)
FORCE_FACTORS = tuple(
    (factor, f"are in {name}" if factor == up else f"are in N in a column of {name}")
    for name, up, down in FORCE_UNITS
    for factor in (up, down)
)
"""By what forces are multiplied, and what they are then."""
