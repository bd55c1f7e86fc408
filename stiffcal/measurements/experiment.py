"""Kinds of experiment whose states are fitted together."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.measurements.load_states import LoadStates


class Experiment(StrEnum):
    """What states were measured in."""

    LOADS = "loads"
    CLAMPED = "clamped"
    ABSOLUTE = "absolute"


def states_of_experiments(states: LoadStates) -> dict[Experiment, Booleans]:
    """Return (n,) which states are of each kind of experiment; kinds without a state in use are left out."""
    masks = {
        Experiment.LOADS: ~states.clamped & ~states.absolute,
        Experiment.CLAMPED: states.clamped,
        Experiment.ABSOLUTE: states.absolute,
    }
    return {kind: mask for kind, mask in masks.items() if np.any(mask & states.used)}
