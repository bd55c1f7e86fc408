"""The Cartesian stiffness at one pose, straight from measured wrenches and displacements (paper 001, eq. 8 to 15).

K̂ᵀ = (Σ ΔX ΔXᵀ)⁻¹ Σ ΔX Wᵀ takes the displacement for exact and the wrench for what errs. With a camera it is the other
way round: noise in ΔX then draws K towards zero, most in directions in which the robot is stiff. The compliance
C = Σ ΔX Wᵀ (Σ W Wᵀ)⁻¹, and its inverse, has no such bias and is given next to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.reduction.loads.cycles import run_members

# Full: even in its weakest direction the displacement follows the wrench by more than noise would let it seem so once
# in a thousand poses.
NOT_FULL_P = 1e-3
# Lengths by which moments and turns are compared with forces and shifts, m.
LENGTH_M = 0.5
FEWEST = 14
# Directions of the wrench below this share of the largest are rounding.
NOTHING = 1e-9


@dataclass(frozen=True)
class CartesianStiffness:
    """At one pose, about the target's origin, base axes."""

    run: str
    """Its name."""
    target: str
    """The frame that was measured."""
    stiffness: Floats
    """(6, 6) by eq. 15, N/m, N/rad, N·m/m, N·m/rad: displacement taken for exact."""
    from_compliance: Floats
    """(6, 6) inverse of the compliance fitted the other way round."""
    compliance: Floats
    """(6, 6) m/N, rad/N, rad/(N·m)."""
    fullness: tuple[float, float]
    """Smallest direction over the largest, of the wrenches and of the displacements (lengths scaled by 0.5 m)."""
    over_noise: float
    """r, variance of the displacement that follows the wrench over that of the rest, in the weakest direction: eq. 15
    draws that direction down to r/(1 + r).
    """
    n: int
    """States."""


def stiffness_by_equation_15(displacement: Floats, wrench: Floats) -> Floats:
    """Return K (6, 6) of W = K ΔX by 001, eq. 15.

    Parameters
    ----------
    displacement : (n, 6) m and rad.
    wrench : (n, 6) N and N·m, both about one point in one frame.

    Examples
    --------
    >>> import numpy as np
    >>> stiffness = np.diag([1e6, 2e6, 3e6, 1e5, 1e5, 5e4])
    >>> wrench = np.vstack([np.eye(6), -np.eye(6)])
    >>> moved = wrench @ np.linalg.inv(stiffness)
    >>> bool(np.allclose(stiffness_by_equation_15(moved, wrench), stiffness))
    True
    """
    return np.asarray(np.linalg.lstsq(displacement, wrench, rcond=None)[0].T)


def cartesian_stiffnesses(states: LoadStates, chain: Chain) -> tuple[CartesianStiffness, ...]:
    """Return the poses in which wrench and displacement of the tool are both full; none where no run is."""
    if states.deflection_given or not states.setup.moments_measured or not states.has_orientation:
        return ()
    measured = (
        states.used
        & np.isfinite(states.rotation[:, 0]).all(axis=(1, 2))
        & np.isfinite(states.wrench).all(axis=1)
        & np.isfinite(states.position[:, 0]).all(axis=1)
    )
    measured_in_runs = [members[measured[members]] for members in run_members(states.run)]
    whole_runs = [kept for kept in measured_in_runs if len(kept) >= FEWEST]
    stiffnesses = []
    for kept, displacement, wrench in _at_target(states, chain, whole_runs):
        if not displacement.any():
            continue
        full = (
            _fullness(wrench, np.repeat([1.0, 1.0 / LENGTH_M], 3)),
            _fullness(displacement, np.repeat([1.0, LENGTH_M], 3)),
        )
        compliance: Floats = np.asarray(np.linalg.lstsq(wrench, displacement, rcond=NOTHING)[0].T, dtype=np.float64)
        over_noise = _over_noise(wrench @ compliance.T, displacement)
        if _chance_of_following(over_noise, len(kept)) > NOT_FULL_P:
            continue
        name = states.runs[int(states.run[kept[0]])].name
        stiffnesses.append(
            CartesianStiffness(
                name,
                states.setup.target_names[0],
                stiffness_by_equation_15(displacement, wrench),
                np.asarray(np.linalg.inv(compliance), dtype=np.float64),
                compliance,
                full,
                over_noise,
                len(kept),
            )
        )
    return tuple(stiffnesses)


def _at_target(
    states: LoadStates, chain: Chain, whole_runs: Sequence[NDArray[np.int64]]
) -> Iterator[tuple[NDArray[np.int64], Floats, Floats]]:
    """Yield each run's states (n,), displacements and wrenches (n, 6) about the target, base axes, less their means."""
    if not whole_runs:
        return
    joints = np.stack([states.joints[kept].mean(axis=0) for kept in whole_runs])
    angles, setup = chain.model_angles(joints), states.setup
    _, axes = attached_poses(chain, angles, setup.wrench_axes)
    arms = attached_poses(chain, angles, setup.wrench_point)[0] - attached_poses(chain, angles, setup.targets[0])[0]
    for kept, axis, arm in zip(whole_runs, axes, arms, strict=True):
        force = states.wrench[kept, :3] @ axis.T
        moment = states.wrench[kept, 3:] @ axis.T + np.cross(arm, force)
        turn = states.rotation[kept, 0] @ states.rotation[kept[0], 0].T
        displacement = np.concatenate(
            [states.position[kept, 0] - states.position[kept[0], 0], vector_from_rotation(turn)], axis=1
        )
        wrench = np.concatenate([force, moment], axis=1)
        # the run's offset: the reference reading is as noisy as the others
        yield kept, displacement - displacement.mean(axis=0), wrench - wrench.mean(axis=0)


def _fullness(values: Floats, scale: Floats) -> float:
    singular = np.linalg.svd(values * scale, compute_uv=False)
    return float(singular[-1] / singular[0]) if singular[0] > 0.0 else 0.0


def _over_noise(follows: Floats, displacement: Floats) -> float:
    """Return the least ratio of variances, over all directions, of what follows the wrench and of what does not.

    Parameters
    ----------
    follows, displacement : (n, 6) displacements by the fitted compliance, and as measured, less their means.
    """
    scale = np.repeat([1.0, LENGTH_M], 3)
    residual = (displacement - follows) * scale
    # a run's offset and six columns were fitted
    noise = (
        residual.T @ residual / (len(residual) - 7)
        + np.eye(6) * (1e-12 * float(np.max(np.abs(displacement * scale)))) ** 2
    )
    whiten = np.linalg.inv(np.linalg.cholesky(noise))
    return float(
        np.linalg.eigvalsh(whiten @ (follows * scale).T @ (follows * scale) @ whiten.T)[0] / (len(residual) - 1)
    )


def _chance_of_following(ratio: float, n: int) -> float:
    """Return the chance of such a ratio where nothing follows the wrench: six columns fitted to noise.

    The tail of F with 6 and n − 7 degrees of freedom, in closed form as 6 is even.

    Examples
    --------
    >>> round(_chance_of_following(6.0 / 59.0 * 4.37, 60), 4)
    0.0012
    """
    b = (n - 7) / 2.0
    x = 1.0 / (1.0 + ratio * (n - 1) / (n - 7))
    return float(x**b * (1.0 + b * (1.0 - x) + 0.5 * b * (b + 1.0) * (1.0 - x) ** 2))
