"""Measured forces against known masses that hang on the robot: the one check of a whole campaign's unit of force.

A campaign whose forces are all in one wrong unit agrees with itself, and robots differ by more than 4.4 in stiffness:
only a weight that is known shows it. It is a warning, as a mass may hang on in part while the robot is pulled as well.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quantities import unit
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.wording import significant

# m/s²
STANDARD_GRAVITY = 9.80665
# With fewer loaded states a slip of the pen is as likely.
LEAST_LOADED = 3
# A mass is known to a per cent and a force sensor to some: beyond a tenth the two differ …
DIFFERS = 0.1
# … and within this of a ratio of units, that is what it is.
MATCHES = 0.05
# kg: masses that differ by less are one load.
LEAST_MASS = 0.1
UNITS = ("N", "kgf", "lbf", "kN")


def force_over_weight(raw_states: RawStates) -> float | None:
    """Return the measured change of the force over that of the known weight, the median of all loaded states.

    Changes are taken from each run's first state, so that a tool's weight and a sensor's zero are out. None where
    fewer than three states have both a measured force and a known mass.
    """
    if "mass" not in raw_states.signals or "wrench" not in raw_states.signals:
        return None
    mass, force = raw_states.signals["mass"][:, 0], raw_states.signals["wrench"][:, :3]
    _, first, run = np.unique(raw_states.run, return_index=True, return_inverse=True)
    reference = first[run]
    several = np.bincount(run)[run] > 1
    weight = STANDARD_GRAVITY * np.abs(mass - np.where(several, mass[reference], 0.0))
    change: Floats = np.linalg.norm(force - np.where(several[:, None], force[reference], 0.0), axis=1)
    loaded = (weight > LEAST_MASS * STANDARD_GRAVITY) & np.isfinite(change)
    if np.count_nonzero(loaded) < LEAST_LOADED:
        return None
    return float(np.median(change[loaded] / weight[loaded]))


def weight_warnings(raw_states: RawStates) -> list[str]:
    """Return a warning where measured forces are not those of the masses that hang on; else nothing."""
    ratio = force_over_weight(raw_states)
    if ratio is None or abs(ratio - 1.0) <= DIFFERS:
        return []
    if ratio <= 0.0:
        return ["the measured force does not change with the masses of dead_weight: check its columns"]
    fitting = [
        f"forces in {logged} in a column of {declared}"
        for logged in UNITS
        for declared in UNITS
        if abs(ratio * unit(logged, "force").factor / unit(declared, "force").factor - 1.0) <= MATCHES
    ]
    fits = f" (possible: {' or '.join(fitting)})" if fitting else ""
    sentence = f"measured forces are {significant(ratio)} times the weight of the masses of dead_weight"
    return [f"{sentence}: check the unit of force of the whole campaign{fits}"]
