"""How well kinematics meets the tracker in the reference states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector

# Physics, section 0: kinematics meets the measured target within some 20 mm in the reference states.
MEETS_M = 0.02
# Beyond this no robot's own inaccuracy explains it; between the two a warning is enough.
MISSES_M = 0.05
# Likewise of orientations: 50 mm at half a metre.
TURNED_RAD = 0.1


@dataclass(frozen=True)
class KinematicsMatch:
    """How well kinematics meets the tracker in the reference states."""

    median_m: float
    """Median distance between the computed and the measured target; NaN where positions are not measured."""
    worst_m: float
    """The largest such distance."""
    turned_rad: float
    """Median angle between the computed and the measured orientation, NaN where not measured."""


def match_kinematics(states: LoadStates, chain: Chain) -> KinematicsMatch:
    """Compare kinematics with the measured target in the reference states."""
    chosen = references_of(states)
    if len(chosen) == 0:
        return KinematicsMatch(np.nan, np.nan, np.nan)
    away, turn = np.linalg.norm(missed_by(chosen, chain), axis=1), turned_by(chosen, chain)
    median_angle = float(np.median(turn)) if np.isfinite(turn).all() else np.nan
    return KinematicsMatch(float(np.median(away)), float(away.max()), median_angle)


def references_of(states: LoadStates) -> LoadStates:
    """Return the states that frames are found from: used, unloaded, and with the first target measured."""
    measured = (
        np.isfinite(states.position[:, :1]).all(axis=(1, 2)) if states.setup.targets else np.zeros(len(states), bool)
    )
    return states.select(states.reference & states.used & measured)


def turned_by(states: LoadStates, chain: Chain) -> Floats:
    """Return (n,) the angle between the computed and the measured orientation of the first target, rad."""
    _, rotation = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    return np.asarray(np.linalg.norm(rotation_vector(states.rotation[:, 0] @ np.swapaxes(rotation, -1, -2)), axis=1))


def missed_by(states: LoadStates, chain: Chain) -> Floats:
    """Return (n, 3) the first target's measured less its computed place, m, base axes."""
    predicted, _ = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    return np.asarray(states.position[:, 0] - predicted)
