"""Whether each run's place is where the joint angles put the target: the others show how well that is known."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.thresholds import LEAST_PLACES
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.uncertainty import NORMAL_MAD

# m; a robot's own inaccuracy and its sag under weight, which differ from pose to pose, come to some 20 mm (physics,
# section 0); five of these units are beyond that.
LEAST_MISS = 6e-3


def place_misses(states: LoadStates, chain: Chain) -> Floats:
    """Return (n, 3) the first target's measured place less the computed one, m; NaN where none was measured."""
    if not states.setup.targets:
        return np.full((len(states), 3), np.nan)
    predicted_position, _ = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    return np.asarray(states.position[:, 0] - predicted_position)


def place_scores(misses: Floats, members: list[Integers]) -> tuple[Floats, Floats, float]:
    """Return how far each run's place is from where the angles put it, in units of what the runs have in common.

    Parameters
    ----------
    misses : (n, 3) as of `place_misses`. members : the states of each of R runs.

    Returns
    -------
    scores : (R,) zero where no place was measured.
    centre : (3,) the median miss, m.
    unit : m, what is one in the scores; a miss below five of them is no more than other runs have.
    """
    first = np.array(
        [misses[run_states[np.isfinite(misses[run_states]).all(axis=1)]][:1].ravel() for run_states in members],
        dtype=object,
    )
    is_measured = np.array([len(entry) == 3 for entry in first], dtype=np.bool_)
    if is_measured.sum() < LEAST_PLACES:
        return np.zeros(len(members)), np.zeros(3), LEAST_MISS
    table = np.array(list(first[is_measured]), dtype=np.float64)
    centre = np.median(table, axis=0)
    away = np.linalg.norm(table - centre, axis=1)
    unit = max(LEAST_MISS, NORMAL_MAD * float(np.median(away)))
    scores = np.zeros(len(members))
    scores[is_measured] = away / unit
    return scores, centre, unit
