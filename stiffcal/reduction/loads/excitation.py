"""The load on each joint, and whether that is enough to identify its compliance.

A first-order look before any fit: columns J Δτ of every drive's compliance, the scatter that is left, and the
uncertainty that follows. It answers "which pose or load is still missing" while one can still measure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.reduction.loads.motion import less_means_of_runs, motion_of
from stiffcal.uncertainty import NORMAL_95, is_poorly_known
from stiffcal.wording import significant

# A torque below this share of the largest joint's is none that matters.
NO_TORQUE = 1e-3
# A standard uncertainty above this share of the value leaves open whether the joint gives at all.
NOT_KNOWN = 1.0


@dataclass(frozen=True)
class JointExcitation:
    """The load on one joint."""

    name: str
    """The joint."""
    torque: float
    """Largest change of torque on its drive within a run, N·m; of a prismatic joint of force along its axis, N."""
    relative_std: float
    """Standard uncertainty over value that a fit of joint compliances can expect; NaN where unknown."""
    identifiable: bool
    """False where its compliance cannot be determined."""
    verdict: str
    """In words."""


def joint_excitation(states: LoadStates, chain: Chain) -> list[JointExcitation]:
    """Return the torques of each joint in the states that are used."""
    used = states.select(states.used)
    names = chain.joint_names
    if len(used) == 0 or not used.setup.targets or not np.any(used.wrench):
        return [JointExcitation(name, 0.0, np.nan, False, "no load was applied") for name in names]
    torque, design, measured = _first_order_equations(used, chain)
    largest = np.abs(torque).max(axis=0)
    # a force along an axis counts as the torque that it has at the robot's reach
    reach = float(np.linalg.norm(chain.fixed[:, :3, 3], axis=1).sum()) or 1.0
    torque_like = largest * np.where(chain.prismatic, reach, 1.0)
    is_loaded = torque_like > NO_TORQUE * torque_like.max()
    if not is_loaded.any():  # every axis runs along or through every force
        return [
            _verdict(name, float(largest[k]), np.nan, is_loaded=False, prismatic=bool(chain.prismatic[k]))
            for k, name in enumerate(names)
        ]
    relative = _relative_std(design[:, is_loaded], measured)
    uncertainty = np.full(largest.size, np.nan)
    uncertainty[is_loaded] = relative
    return [
        _verdict(
            name,
            float(largest[k]),
            float(uncertainty[k]),
            is_loaded=bool(is_loaded[k]),
            prismatic=bool(chain.prismatic[k]),
        )
        for k, name in enumerate(names)
    ]


def _first_order_equations(states: LoadStates, chain: Chain) -> tuple[Floats, Floats, Floats]:
    """Return the equations displacement = columns @ compliances of the rigid chain, one per measured component.

    All are taken from their run's mean, as positions have an unknown offset per run; not so where deflections are
    given, which are counted from the unloaded state already.

    Returns
    -------
    (n, J) torques on the drives, N·m; (k, J) columns J Δτ, m per rad/(N·m); (k,) displacements, m. k is the number of
    components measured in all states together: those that are NaN are left out.
    """
    angles = chain.model_angles(states.joints)
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    wrench = np.concatenate(
        [np.einsum("nij,nj->ni", axes, states.wrench[:, :3]), np.einsum("nij,nj->ni", axes, states.wrench[:, 3:])],
        axis=1,
    )
    # a drive that turns several joints (a parallel rod) carries the torque of each: τ_drive = Mᵀ τ, δ = M δ_drive
    drives = chain.drive_axes
    torque = np.einsum("nij,ni->nj", jacobians(chain, angles, states.setup.wrench_point), wrench) @ drives
    motion = motion_of(states, chain, all_targets=True)
    columns, measured = (motion.columns(states, chain) @ drives) * torque[:, None, :], motion.measured
    if not states.deflection_given:
        torque, columns, measured = (less_means_of_runs(values, states.run) for values in (torque, columns, measured))
    rows = np.isfinite(measured).ravel()
    return torque, columns.reshape(-1, columns.shape[2])[rows], measured.ravel()[rows]


def _relative_std(design: Floats, measured: Floats) -> Floats:
    """Return standard uncertainty over value of non-negative compliances, errors scaled by what is left."""
    scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    gram, right = np.linalg.qr(design / scale)
    zero = np.zeros(right.shape[1])
    value, _ = least_squares_within(right, gram.T @ measured, zero, zero + np.inf)
    free = design.shape[0] - design.shape[1]
    if free <= 0:
        return np.full(design.shape[1], np.inf)
    residual = measured - design / scale @ value
    variance = float(residual @ residual) / free
    _, singular, turned = np.linalg.svd(right)
    safe = np.where(singular > 1e-9 * singular[0], singular, np.nan)
    spread = np.sqrt(variance * np.nansum((turned / safe[:, None]) ** 2, axis=0))
    open_directions = np.isnan(safe) & True
    for k in np.flatnonzero(open_directions):
        spread[np.abs(turned[k]) > 0.1] = np.inf
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(value > 0.0, spread / np.maximum(value, 1e-300), np.inf))


def _verdict(name: str, torque: float, relative: float, *, is_loaded: bool, prismatic: bool) -> JointExcitation:
    load, axis = ("force", "along its axis") if prismatic else ("torque", "about its axis")
    if not is_loaded:
        lever = "" if prismatic else "with a lever arm "
        text = f"carries no {load} in these poses: load it {lever}{axis}"
        return JointExcitation(name, torque, np.nan, False, text)
    if relative > NOT_KNOWN:
        text = (
            "its stiffness cannot be distinguished from that of the other joints: add poses or load directions "
            f"with more {load} on it"
        )
        return JointExcitation(name, torque, relative, False, text)
    half_width = 100.0 * NORMAL_95 * relative
    if is_poorly_known(1.0, relative):
        text = f"poorly determined, ± {half_width:.0f} % (95 %): more {load} {axis} would help"
        return JointExcitation(name, torque, relative, True, text)
    return JointExcitation(
        name, torque, relative, True, f"expected uncertainty about ± {significant(half_width, 2)} % (95 %)"
    )
