"""Components of a target's place that stand still, in the axes of the instrument, though the target moves."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.tracker_axes import places_in_tracker
from stiffcal.reduction.logs.reading_bounds import LARGEST_DEFLECTION_M

# Fewer places may have a component in common.
LEAST_PLACES = 4
# Of the largest reading: what turning to base axes and back, and means of equal readings, leave in floating point.
_ROUNDED = 1e-12


def rounding_of(measured: Floats) -> float:
    """Return by how much equal readings (n, k) m, turned from base axes to the instrument's, may differ, m."""
    return _ROUNDED * float(np.nanmax(np.abs(measured), initial=0.0))


def lost_states(states: LoadStates) -> Booleans:
    """Return (n,) True where a component is zero, or that of another state to the last digit and far from the rest.

    Readings far from each other never agree in every digit: such values were filled in.

    Parameters
    ----------
    states : of one run, in which targets move by less than `LARGEST_DEFLECTION_M`.
    """
    places = places_in_tracker(states).reshape(len(states), -1)
    rounding = rounding_of(states.position)
    lost: Booleans = np.asarray((np.abs(places) <= rounding).any(axis=1))
    for component in places.T:
        read = component[~lost & np.isfinite(component)]
        if not read.size:
            continue
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(np.abs(component - _middle(read, rounding)) > LARGEST_DEFLECTION_M)
        alike = np.abs(component[rows][:, None] - component[rows]) <= rounding
        lost[rows[alike.sum(axis=1) > 1]] = True
    return lost


def _middle(values: Floats, rounding: float) -> float:
    """Return the median of different values: a number that was filled in counts once."""
    ordered = np.sort(values)
    return float(np.median(ordered[np.diff(ordered, prepend=-np.inf) > rounding]))


def still_components(states: LoadStates) -> list[str]:
    """Return which components of which target are the same in all places, as "Z of probe", while others move it."""
    found = []
    for target, places in zip(states.setup.target_names, places_in_tracker(states).swapaxes(0, 1), strict=True):
        seen = places[np.isfinite(places).all(axis=1)]
        if len(seen) < LEAST_PLACES:
            continue
        extent = np.ptp(seen, axis=0)
        if extent.max() > LARGEST_DEFLECTION_M:
            still = extent <= 2.0 * rounding_of(states.position)
            found += [f"{'XYZ'[k]} of {target}" for k in np.flatnonzero(still)]
    return found


def still_words(states: LoadStates) -> tuple[str, str]:
    """Return what to add to the reason of places that contradict joint angles, and what to check first; or nothing."""
    still = still_components(states)
    if not still:
        return "", ""
    names = " and ".join(still)
    return f"; {names}, in the axes of the instrument, is the same in all {len(states)} states", (
        f"check the column of {names} first: a dead channel, or filled in; then "
    )
