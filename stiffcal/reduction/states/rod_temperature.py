"""Rods on links that get warmer: the link grows along a rod, and the rod grows too.

A rod reads by how much the distance of two points of the link outgrows it: ΔL = l (α_link − α_rod) (T − T_ref), besides
what the load does. A metre of cast iron against an Invar rod makes 9 µm a kelvin, as much as a load. Where both
expansions and a temperature are known it is taken out of the readings before anything else. What is missing of this is
found by the rods themselves (`mistakes.rods.faults`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.varying import varies

# A link of hundreds of kilograms takes an hour to follow the hall. Within a run its temperature is a slow curve; a
# thermometer's noise around it, times a metre of cast iron, would be as large as the rods' own.
CURVE = 2
FEWEST = 3 * (CURVE + 1)


def without_growth(states: LoadStates) -> LoadStates:
    """Take out of the rods' readings what they and their links grow by as they get warmer (`grown_lengths`)."""
    grown = grown_lengths(states)
    return replace(states, lengths=states.lengths - grown) if grown.any() else states


def grown_lengths(states: LoadStates) -> Floats:
    """Return (n, R) m, by how much each rod's reading has grown with the temperature since its run's first state.

    The temperature is the first that is logged, of link and rods alike. Rods whose growth is not known count as
    steady, and so do runs without a temperature.
    """
    growth, grown = np.nan_to_num(rod_growth(states)), np.zeros_like(states.lengths)
    if not growth.any() or not states.temperature.shape[1]:
        return grown
    for members in states.members():
        if len(members) and np.isfinite(states.temperature[members, 0]).all():
            warmer = smooth_in_time(states.time[members], states.temperature[members, 0])
            grown[members] = np.outer(warmer - warmer[0], growth)
    return grown


def rod_growth(states: LoadStates) -> Floats:
    """Return (R,) m/K of all rods, in the order of ``LoadStates.lengths``; NaN where not known."""
    growths = [rods.growth if len(rods.growth) else np.full(len(rods.names), np.nan) for rods in states.setup.rods]
    return np.concatenate(growths) if growths else np.zeros(0)


def smooth_in_time(time: Floats, temperature: Floats) -> Floats:
    """Return (n,) a run's temperature as a slow curve of time; as read where readings are too few, or have no times."""
    if len(time) < FEWEST or not np.isfinite(time).all() or not varies(time):
        return temperature
    since = (time - time.mean()) / np.ptp(time)
    powers = since[:, None] ** np.arange(CURVE + 1)
    return np.asarray(powers @ np.linalg.lstsq(powers, temperature, rcond=None)[0])
