"""Poses of bodies from several points on them: which points were measured, and how far the pose is known by them.

Points that err alike and independently give the place of their middle and, independently of it, the turn: with k
points measured the middle errs by σ²/k on every axis, the turn by σ² S⁻¹, S = Σ (r² I − r rᵀ) over the points' places r
from their middle. A body's frame that is not in the middle of these moves with the turn: its place errs with it
(the covariance of the pose's linear least squares; Arun, Huang and Blostein 1987 for the pose).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats

# Points this close to one line, by the second largest of their spreads over the largest, give no turn about it.
ON_A_LINE = 1e-3
FEWEST = 3


@dataclass(frozen=True)
class Markers:
    """Points on one body."""

    names: tuple[str, ...]
    """k of them."""
    places: Floats
    """(k, 3) in the body's frame, m."""

    @property
    def turn_variance(self) -> float:
        """1/m²: variance of the turn by all points, mean of the axes, for points of unit noise."""
        return float(np.trace(_middle_and_turn(self.places)[1])) / 3.0

    def pose_sigma(self, point_sigma: float) -> tuple[float, float]:
        """Return the standard uncertainty of the points' middle, m, and of the turn by all of them, rad, per axis.

        Parameters
        ----------
        point_sigma : standard uncertainty of each coordinate of one point, m.

        Examples
        --------
        >>> import numpy as np
        >>> cross = Markers(tuple("abcd"), np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]))
        >>> [round(float(sigma), 4) for sigma in cross.pose_sigma(0.1)]
        [0.05, 0.0645]
        """
        return point_sigma / float(np.sqrt(len(self.names))), point_sigma * float(np.sqrt(self.turn_variance))

    def covariance(self, measured_mask: Booleans, rotation: Floats) -> Floats:
        """Return (n, 6, 6) of poses, base axes, for points of unit noise on every axis; parameters as in `spread`."""
        share, covariance = self.spread(measured_mask, rotation)
        result = self.turn_variance * covariance
        result[:, range(3), range(3)] += share[:, None] / len(self.names)
        return np.asarray(result)

    def enough(self, measured_mask: Booleans) -> Booleans:
        """Return (n,) whether the measured points of a state (n, k) give a pose: three or more, not on one line."""
        patterns, number = np.unique(measured_mask, axis=0, return_inverse=True)
        good = []
        for mask in patterns:
            places = self.places[mask]
            spread = (
                np.linalg.svd(places - places.mean(axis=0), compute_uv=False) if len(places) >= FEWEST else np.zeros(2)
            )
            good.append(bool(spread[1] > ON_A_LINE * spread[0]))
        return np.array(good, dtype=np.bool_)[number.reshape(-1)]

    def spread(self, measured_mask: Booleans, rotation: Floats) -> tuple[Floats, Floats]:
        """Return how much less is known of poses than where every point is measured.

        The covariance of a pose (displacement and turn of the body's frame, base axes) is σ_t² A + σ_r² B, with σ_t
        the noise of the middle of all points and σ_r that of the turn by all points, root mean square over the axes.

        Parameters
        ----------
        measured_mask : (n, k).
        rotation : (n, 3, 3) base_from_body; NaN where there is no pose.

        Returns
        -------
        a : (n,) what stands on the three places of A's diagonal that are the displacement's; the rest is zero.
        b : (n, 6, 6) B. Both are those of an ordinary pose, 1 and the turn's unit matrix, where there is none.

        Examples
        --------
        >>> import numpy as np
        >>> cross = Markers(tuple("abcd"), np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]))
        >>> a, b = cross.spread(np.array([[True] * 4, [True, True, True, False]]), np.tile(np.eye(3), (2, 1, 1)))
        >>> a.round(3).tolist(), np.diagonal(b[0])[3:].round(3).tolist()
        ([1.0, 1.333], [1.2, 1.2, 0.6])
        """
        n = len(measured_mask)
        share, covariance = np.ones(n), np.zeros((n, 6, 6))
        covariance[:, range(3, 6), range(3, 6)] = 1.0
        usual = self.turn_variance
        posed = np.isfinite(rotation[:, 0, 0]) & self.enough(measured_mask)
        patterns, number = np.unique(measured_mask, axis=0, return_inverse=True)
        for k, mask in enumerate(patterns):
            of_pattern = np.flatnonzero(posed & (number.reshape(-1) == k))
            if not len(of_pattern):
                continue
            middle, turn = _middle_and_turn(self.places[mask])
            share[of_pattern] = len(self.names) / int(np.count_nonzero(mask))
            axes = rotation[of_pattern]
            lever = _cross_matrices(axes @ middle)
            rows = np.concatenate([lever, np.broadcast_to(np.eye(3), lever.shape)], axis=1)
            covariance[of_pattern] = rows @ (axes @ (turn / usual) @ np.swapaxes(axes, 1, 2)) @ np.swapaxes(rows, 1, 2)
        return share, covariance


def _middle_and_turn(places: Floats) -> tuple[Floats, Floats]:
    """Return the middle (3,) of points and the covariance (3, 3) of the turn by them, for points of unit noise."""
    middle = places.mean(axis=0)
    away = places - middle
    inertia = np.sum(away**2) * np.eye(3) - away.T @ away
    return middle, np.asarray(np.linalg.inv(inertia))


def _cross_matrices(vectors: Floats) -> Floats:
    """Return (n, 3, 3) the matrices of v × for (n, 3)."""
    x, y, z = vectors.T
    nothing = np.zeros_like(x)
    return np.moveaxis(np.array([[nothing, -z, y], [z, nothing, -x], [-y, x, nothing]]), -1, 0)
