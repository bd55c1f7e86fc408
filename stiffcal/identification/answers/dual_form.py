"""Joint compliances identified in dual quaternions (Li et al. 2019, paper 003, eq. 30 to 35), next to the matrix form.

y = A x, with y the change of the target's eight components and A the columns ∂q̂/∂θⱼ τⱼ. Eight components are six
displacements mapped by the exact linear map L of `stiffcal.mechanics.dual_quaternions`; a weight of the six goes
over as Pᵀ W P. With it the two forms are one estimate to rounding, at any orientation. The paper leaves the weight out,
and counts metres and pure numbers alike (eq. 35): that is another estimate, which changes with the unit of length, and
is given apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.estimation.constants import without_constants
from stiffcal.estimation.unknowns import free_columns
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.fit_results import ComplianceInTwoForms, DualQuaternionFit
from stiffcal.identification.derivatives.observation import Observations, evaluate, lever_of
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.noise.reading_noise import Noise, whiten
from stiffcal.identification.readings.row_layout import ROTATION, TRANSLATION
from stiffcal.mechanics.dual_balance import dual_rest, joint_torques, reading_as_load, weights_of
from stiffcal.mechanics.dual_quaternions import (
    attached_duals,
    displacement_from_change,
    displacement_map,
    displacement_of_duals,
    dual_chain,
    dual_jacobian,
)
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import NoBalanceError, displacements, rest_under_weight
from stiffcal.model.balance.rest import find_rest
from stiffcal.model.effect import RZ, Inputs, joint_node
from stiffcal.wording import significant

NEEDS = "joint-compliance"
# Steps contract a thousandfold and more: after one of this relative size the next is rounding, and is still taken.
SETTLED = 1e-8
MAX_STEPS = 25
# rad: the balance in the matrix form, as far as it goes.
TIGHT = 1e-15


@dataclass(frozen=True)
class TwoForms:
    """One campaign identified in both forms."""

    names: tuple[str, ...]
    """p full parameter names: the compliances that the fit determines."""
    matrix: Floats
    """(p,) rad/(N·m), matrix form, iterated until its steps are rounding."""
    dual: Floats
    """(p,) rad/(N·m), dual quaternion form with the same weights, iterated until its steps are rounding."""
    unweighted: Floats
    """(p,) by eq. 35 as printed, lengths in metres."""
    unweighted_mm: Floats
    """(p,) the same with lengths in millimetres. NaN where orientation is not measured everywhere."""
    difference: float
    """Largest relative difference between matrix and dual form."""


@dataclass(frozen=True)
class _Task:
    """What both forms work on: observations, weights, which joints' compliances are free and what the others are."""

    data: Observations
    robot: CompliantRobot
    joints: tuple[int, ...]
    start: Floats
    factor: Floats  # (n, m, m) whitening

    def compliances(self, free: Floats) -> Floats:
        """Return (J,) all compliances."""
        all_joints = self.start.copy()
        all_joints[list(self.joints)] = free
        return all_joints


def identify_in_two_forms(fit: Fit) -> TwoForms:
    """Identify joint compliances again, from a fit's observations, in matrices and in dual quaternions.

    Parameters
    ----------
    fit : of joint compliances alone, to the deformed robot.

    Raises
    ------
    InputError : the model holds other effects, or the papers' linear balance.
    """
    task = _task(fit)
    start = task.start[list(task.joints)]
    matrix = _iterate_to_rounding(_matrix_rows, task, start)
    dual = _iterate_to_rounding(_dual_rows, task, start)
    names = tuple(f"joint-compliance.j{joint + 1}.c" for joint in task.joints)
    metres, millimetres = (_unweighted_fit(task, dual, scale) for scale in (1.0, 1e3))
    difference = float(np.max(np.abs(dual / matrix - 1.0), initial=0.0))
    return TwoForms(names, matrix, dual, metres, millimetres, difference)


def two_forms_result(two: TwoForms) -> DualQuaternionFit:
    """Return both forms as ``identify`` answers them; None where a compliance is not known."""

    def number(value: float) -> float | None:
        return float(value) if np.isfinite(value) else None

    return DualQuaternionFit(
        largest_relative_difference=two.difference,
        parameters=[
            ComplianceInTwoForms(
                name=name,
                matrix=float(two.matrix[k]),
                dual_quaternion=float(two.dual[k]),
                unweighted_in_metres=number(two.unweighted[k]),
                unweighted_in_millimetres=number(two.unweighted_mm[k]),
            )
            for k, name in enumerate(two.names)
        ],
    )


def _task(fit: Fit) -> _Task:
    robot, data = fit.robot, fit.data
    other_effects = sorted({placed_effect.effect.name for placed_effect in robot.placed} - {NEEDS})
    if other_effects:
        reason = (
            "the dual-quaternion form (Li et al. 2019) supports joint-compliance only, and the model contains "
            f"{', '.join(other_effects)}"
        )
        raise InputError.at(
            FaultCode.MODEL_UNSUITABLE, "model.toml", "effects", reason, "remove the other effects to use this form"
        )
    if not robot.deformed:
        reason = (
            "the dual-quaternion form uses the equilibrium of the deformed robot, and the model has balance = "
            '"first-order"'
        )
        raise InputError.at(FaultCode.MODEL_UNSUITABLE, "model.toml", "balance", reason, 'write balance = "deformed"')
    if len(data.rows_of(TRANSLATION, ROTATION)) < len(data.measured) or not len(data.measured):
        reason = "the dual-quaternion form needs poses, and other displacements are measured too"
        raise InputError.at(
            FaultCode.MODEL_UNSUITABLE, "campaign.toml", "sources", reason, "remove gauges and rods to use this form"
        )
    start = np.zeros(robot.chain.n_joints)
    joints = []
    for placed_effect in robot.placed:
        joint = placed_effect.place.joints[0] - 1
        start[joint] = placed_effect.amplitude("c")
        if placed_effect.parameter_name("c") in fit.free_names and start[joint] > 0.0:
            joints.append(joint)
    noise = fit.noise or Noise(*_sizes(fit), 0.0, 0.0, "none", 0.0)
    sensitivity = None
    if noise.force or noise.moment:
        blocks = list(evaluate(robot, data, free_columns(robot), with_sensitivity=True))
        sensitivity = np.concatenate([block.sensitivity for block in blocks if block.sensitivity is not None], axis=2)
    whitening = whiten(noise, data, sensitivity)
    m = len(data.measured)
    if whitening.lower is None:
        factor = np.zeros((data.n_states, m, m))
        factor[:, range(m), range(m)] = whitening.scale.T
    else:
        factor = np.moveaxis(whitening.lower, -1, 0)
    return _Task(data, robot, tuple(joints), start, factor)


def _sizes(fit: Fit) -> tuple[float, float]:
    """Return the residuals' size of translation and rotation, where the noise is not known."""
    sizes = []
    for kind in (False, True):
        values = fit.residual[fit.data.rotational == kind]
        sizes.append(float(np.sqrt(np.mean(values**2))) if values.size and values.any() else 1.0)
    return sizes[0], sizes[1]


def _iterate_to_rounding(rows: Callable[[_Task, Floats], tuple[Floats, Floats]], task: _Task, start: Floats) -> Floats:
    """Return the compliances (p,) after Gauss–Newton steps down to rounding.

    Raises
    ------
    InputError : the steps do not shrink to `SETTLED`.
    """
    value, settled, change = start.copy(), False, np.inf
    for _ in range(MAX_STEPS):
        columns, missing = rows(task, value)
        scale = np.sqrt(np.sum(columns**2, axis=0))
        step = np.linalg.lstsq(columns / scale, missing, rcond=None)[0] / scale
        value = value + step
        if settled:
            return np.asarray(value, dtype=np.float64)
        change = float(np.max(np.abs(step) / np.abs(value), initial=0.0))
        settled = change < SETTLED
    reason = (
        f"the iteration does not converge: a step of {significant(change, 2)} of the compliances "
        f"remains after {MAX_STEPS}"
    )
    raise InputError.at(
        FaultCode.NO_CONVERGENCE,
        "model.toml",
        "effects",
        reason,
        "remove joints whose compliance is not identifiable",
    )


def _without_offsets(task: _Task, rows: Floats, offsets: Floats) -> tuple[Floats, Floats]:
    """Take each run's free offset out of whitened rows (n, r, p + 1); return columns (n r, p) and what is missing.

    Parameters
    ----------
    rows : columns and, last, the residual.
    offsets : (n, r, k) how a unit of the run's k offset components shows.
    """
    if task.data.free_offset:
        rows = rows.copy()
        for run in np.unique(task.data.run[task.data.carries_offset]):
            in_run = task.data.run == run
            own = rows[in_run].reshape(-1, rows.shape[2])
            left = without_constants(own.T, offsets[in_run].reshape(len(own), -1)).T
            rows[in_run] = left.reshape(rows[in_run].shape)
    flat = rows.reshape(-1, rows.shape[2])
    return flat[:, :-1], flat[:, -1]


def _matrix_rows(task: _Task, value: Floats) -> tuple[Floats, Floats]:
    """Return whitened columns (n m, p) and residuals (n m,) by matrices: Jacobian columns times torques."""
    data = task.data
    all_joints = task.compliances(value)
    robot = task.robot.with_values(
        {
            placed_effect.parameter_name("c"): float(all_joints[placed_effect.place.joints[0] - 1])
            for placed_effect in task.robot.placed
        }
    )
    inputs = Inputs(data.angles, data.wrench, data.setup)
    try:
        unloaded = rest_under_weight(robot, inputs, TIGHT, data.order)
        loaded = find_rest(robot, inputs, data.order, unloaded.wrench, unloaded.displacement, TIGHT)
    except NoBalanceError as error:
        raise error.at_state(error.state, f"{data.place_of(error.state)}, {error.where}") from None
    displacement = np.stack(displacements(robot, loaded, unloaded))[data.body, data.component]
    missing = np.where(data.measured_mask, data.measured - displacement, 0.0)
    drives = robot.chain.drive_axes
    nodes = [joint_node(k + 1) for k in range(robot.chain.n_joints)]
    torque = drives.T @ (loaded.wrench[nodes, RZ] - unloaded.wrench[nodes, RZ])
    lever = np.stack([lever_of(loaded, data, node, RZ) for node in nodes])
    columns = np.einsum("jmn,jd->dmn", lever, drives)[list(task.joints)] * torque[list(task.joints), None, :]
    stack = np.moveaxis(np.concatenate([np.where(data.measured_mask, columns, 0.0), missing[None]]), (1, 2), (2, 0))
    rows = np.einsum("nab,npb->nap", task.factor, stack)
    return _without_offsets(task, rows, task.factor)


def _dual_parts(task: _Task, value: Floats) -> tuple[list[Floats], list[Floats], list[Floats], list[Floats]]:
    """Return by target q̂ loaded (n, 8), q̂ unloaded, slopes (n, 8, J) by the drives; and, once, torques (n, J)."""
    data, chain = task.data, task.robot.chain
    drives = chain.drive_axes
    compliance = drives @ np.diag(task.compliances(value)) @ drives.T
    angles = np.ascontiguousarray(data.angles.T)
    loads = weights_of(chain, data.setup, data.n_states)
    loads.append(reading_as_load(data.setup, np.ascontiguousarray(data.wrench.T)))
    loaded = dual_chain(chain, dual_rest(chain, compliance, angles, loads))
    # States of one pose share the rest under weight alone.
    poses, pose = np.unique(angles, axis=0, return_inverse=True)
    bare = weights_of(chain, data.setup, len(poses))
    unloaded = dual_chain(chain, dual_rest(chain, compliance, poses, bare) if bare else poses)
    torque = (joint_torques(loaded, loads) - joint_torques(unloaded, bare)[pose]) @ drives
    targets = data.setup.targets
    return (
        [attached_duals(loaded, target) for target in targets],
        [attached_duals(unloaded, target)[pose] for target in targets],
        [dual_jacobian(loaded, target) @ drives for target in targets],
        [torque],
    )


def _dual_rows(task: _Task, value: Floats) -> tuple[Floats, Floats]:
    """Return whitened columns (n m, p) and residuals (n m,) by dual quaternions: y and A of eq. 31 to 33, weighted."""
    data = task.data
    after, before, slopes, (torque,) = _dual_parts(task, value)
    rows: list[Floats] = []
    for b, (loaded, unloaded, slope) in enumerate(zip(after, before, slopes, strict=True)):
        of_body = data.body == b
        forward, back = displacement_map(loaded), displacement_from_change(loaded)
        missing = np.zeros((data.n_states, 6))
        missing[:, data.component[of_body]] = (
            data.measured[of_body].T - displacement_of_duals(loaded, unloaded)[:, data.component[of_body]]
        )
        eight = np.concatenate(
            [slope[:, :, list(task.joints)] * torque[:, None, list(task.joints)], forward @ missing[:, :, None]], axis=2
        )
        rows.append((back @ eight)[:, data.component[of_body]])
    stack = np.concatenate(rows, axis=1) * data.measured_mask.T[:, :, None]
    return _without_offsets(task, task.factor @ stack, task.factor)


def _unweighted_fit(task: _Task, value: Floats, per_metre: float) -> Floats:
    """Return the compliances (p,) by eq. 35 as printed: (AᵀA)⁻¹ Aᵀ y, eight components alike, no free offsets.

    Parameters
    ----------
    value : the compliances that A is made with: it holds the torques on the deformed robot.
    per_metre : the unit of length: 1 for metres, 1000 for millimetres.
    """
    data = task.data
    zeros = np.zeros(len(task.joints))
    if not data.measured_mask.all() or len(data.measured) != 6 * len(data.setup.targets):
        return np.full_like(zeros, np.nan)
    after, _, slopes, (torque,) = _dual_parts(task, value)
    rows, right = [], []
    for b, (loaded, slope) in enumerate(zip(after, slopes, strict=True)):
        size = np.repeat([1.0, per_metre], 4)[None, :, None]
        rows.append(slope[:, :, list(task.joints)] * torque[:, None, list(task.joints)] * size)
        right.append(displacement_map(loaded) @ data.measured[data.body == b].T[:, :, None] * size)
    columns = np.concatenate(rows, axis=1).reshape(-1, len(task.joints))
    return np.asarray(np.linalg.lstsq(columns, np.concatenate(right, axis=1).reshape(-1), rcond=None)[0])
