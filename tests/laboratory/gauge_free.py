"""Two rigid robots compared without gauge: places of their targets, after the best rigid alignment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.fit import Fit
from stiffcal.mechanics.kinematics import stacked_bodies
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.rest import reported_targets
from stiffcal.model.effect import Inputs

N_DRAWS = 20_000
STEP = 1e-6
"""m and rad, of the forward differences: their second-order terms are 1e-6 of the derivative, rounding 1e-9 of it."""


@dataclass(frozen=True)
class GaugeFree:
    """How far the fitted robot's targets are from the true robot's, and how far they may be."""

    rms: float
    """m, over poses and targets, after the best rigid alignment."""
    predicted: float
    """m, the root of the mean square that the fit's covariance predicts."""
    freedom: float
    """Effective degrees of freedom of that mean square, (Σ λ)²/Σ λ²."""
    probability: float
    """Of a mean square at least as large, the estimates being normal."""

    @property
    def ratio(self) -> float:
        """The one over the other."""
        return self.rms / self.predicted


def rigid_places(fit: Fit, robot: CompliantRobot, angles: Floats) -> Floats:
    """Return (n k, 3) m of k targets as the tracker reports them on the rigid robot.

    Parameters
    ----------
    angles : (joints, n) rad, model angles.

    Frames, zeros and geometry are the robot's; eccentricities are left out.
    """
    inputs = Inputs(angles, np.zeros((6, angles.shape[1])), fit.data.setup)
    for placed in robot.placed:
        if placed.effect.name != "joint-eccentricity":
            inputs = placed.adjusted(inputs)
    reported = reported_targets(stacked_bodies(robot.adjusted_chain, inputs.angles), inputs)
    return np.array([target.position.T for target in reported]).swapaxes(0, 1).reshape(-1, 3)


def aligned_difference(found: Floats, true: Floats) -> Floats:
    """Return (n, 3) ``found`` minus ``true``, both (n, 3), after the rigid motion that brings them closest (Kabsch)."""
    found, true = found - found.mean(axis=0), true - true.mean(axis=0)
    left, _, right = np.linalg.svd(found.T @ true)
    return np.asarray(found @ (left @ right) - true)


def compare_rigid(fit: Fit, true: Floats, places: Callable[[CompliantRobot], Floats]) -> GaugeFree:
    """Compare a fit's places with the true ones (n, 3).

    Parameters
    ----------
    places : of a robot, (n, 3) m, as `rigid_places` returns them.

    The mean square is Σ λ z², z standard normal, λ the eigenvalues of the places' covariance over n, rigid motions
    taken out.
    """
    found = places(fit.robot)
    rms = float(np.sqrt(np.mean(np.sum(aligned_difference(found, true) ** 2, axis=1))))
    chosen = [k for k, name in enumerate(fit.free_names) if name.startswith(("link-geometry", "frame", "joint-offset"))]
    values, columns = fit.robot.values(), []
    for name in (fit.free_names[k] for k in chosen):
        columns.append((places(fit.robot.with_values({name: values[name] + STEP})) - found).ravel() / STEP)
    rigid = [
        np.tile(np.eye(3), (len(found), 1)),
        np.swapaxes(np.cross(np.eye(3)[None], found[:, None]), 1, 2).reshape(-1, 3),
    ]
    basis, _ = np.linalg.qr(np.concatenate(rigid, axis=1))
    spread = np.array(columns).T
    spread -= basis @ (basis.T @ spread)
    eigenvalues = np.linalg.eigvals(fit.covariance[np.ix_(chosen, chosen)] @ (spread.T @ spread)).real / len(found)
    drawn = np.random.default_rng(4).standard_normal((N_DRAWS, len(chosen))) ** 2 @ eigenvalues
    freedom = float(eigenvalues.sum() ** 2 / np.sum(eigenvalues**2))
    return GaugeFree(rms, float(np.sqrt(eigenvalues.sum())), freedom, float(np.mean(drawn >= rms**2)))
