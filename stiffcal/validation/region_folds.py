"""Which poses are left out together where each row is a pose of its own: regions of the joints' ranges, or at random.

An error of a model shows where it has to reach beyond its data: a whole region left out asks that, a random share of
densely measured poses does not.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.mechanics.like_poses import SAME_POSE_RAD, pose_groups

REGIONS = 6
_SEED = 20260
_STARTS = 10


def region_folds(data: Observations) -> Integers:
    """Return (n,) the region of each row: k-means of (cos q, sin q) of the joints, rows within 1° in one region.

    Of a prismatic joint q is half a turn over the range that was measured, and 17.5 mm count as 1°.
    """
    pose, first = _poses(data)
    angles = data.phases[:, first]
    features = np.concatenate([np.cos(angles), np.sin(angles)]).T
    return _compact(_nearest_means(features, min(REGIONS, len(first)))[pose])


def random_folds(data: Observations) -> Integers:
    """Return (n,) the number of each row's share of the poses, as many shares as regions, drawn with a fixed seed."""
    pose, first = _poses(data)
    order = np.random.default_rng(_SEED).permutation(len(first))
    share = np.empty(len(first), dtype=np.int64)
    share[order] = np.arange(len(first)) % min(REGIONS, len(first))
    return _compact(share[pose])


def _poses(data: Observations) -> tuple[Integers, Integers]:
    """Return (n,) the pose of each row, and the first row of each pose."""
    pose = pose_groups(data.angles.T, SAME_POSE_RAD)
    _, first = np.unique(pose, return_index=True)
    return pose, first


def _nearest_means(features: Floats, n_regions: int) -> Integers:
    """Return (n,) clusters by Lloyd's iteration from the best of several seeded starts (k-means++)."""
    rng = np.random.default_rng(_SEED)
    best, least = np.zeros(len(features), dtype=np.int64), np.inf
    for _ in range(_STARTS):
        centres = features[[rng.integers(len(features))]]
        while len(centres) < n_regions:
            away = _squares(features, centres).min(axis=1)
            # like poses are one pose already: some row is always away from all centres
            centres = np.vstack([centres, features[rng.choice(len(features), p=away / away.sum())]])
        region = np.full(len(features), -1)
        while True:  # each round lowers the sum of squares, and there are finitely many divisions: it ends
            nearest = np.argmin(_squares(features, centres), axis=1)
            if np.array_equal(nearest, region):
                break
            region = nearest
            centres = np.stack(
                [features[region == k].mean(axis=0) if (region == k).any() else centres[k] for k in range(n_regions)]
            )
        spread = float(_squares(features, centres)[np.arange(len(features)), region].sum())
        if spread < least:
            best, least = region, spread
    return best


def _squares(features: Floats, centres: Floats) -> Floats:
    """Return (n, k) squared distances."""
    return np.asarray(np.sum((features[:, None] - centres[None]) ** 2, axis=2))


def _compact(fold: Integers) -> Integers:
    """Number the folds 0 … without gaps."""
    return np.asarray(np.unique(fold, return_inverse=True)[1].reshape(-1), dtype=np.int64)
