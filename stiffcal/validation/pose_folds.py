"""What is left out together of states in poses that a person chose: all runs in one pose."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.estimation.constants import stretches
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.mechanics.like_poses import SAME_POSE_RAD, pose_groups


def pose_folds(data: Observations) -> Integers:
    """Return (n,) fold numbers: runs whose joints agree within 1° share one."""
    edges = stretches(data.run)
    fold_of_run = pose_groups(data.angles[:, edges].T, SAME_POSE_RAD)
    counts = np.diff(np.append(edges, data.n_states))
    return np.asarray(np.repeat(fold_of_run, counts), dtype=np.int64)
