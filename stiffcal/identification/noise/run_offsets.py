"""The constant offset of each run: the error of its reference."""

from __future__ import annotations

from stiffcal.estimation.constants import StretchConstants, stretches
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.readings.observations import Observations


def run_offsets(data: Observations, whitening: Whitening, states: slice = slice(None)) -> StretchConstants:
    """Return the constants that runs of displacements carry.

    Parameters
    ----------
    data : the observations. states : which of them, whole runs. whitening : of these.
    """
    edges = stretches(data.run[states])
    return StretchConstants(edges, data.carries_offset[states][edges], whitening.scale, whitening.lower)
