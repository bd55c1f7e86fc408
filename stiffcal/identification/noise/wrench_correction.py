"""Where the wrench of a clamped state lies most probably, given the motor's angle (errors in variables).

In a play the angle rises by its whole width within a torque that the sensor may hardly resolve. There the angle shows
the torque better than the sensor does: a model that is evaluated at the torque as read is compared at the wrong place
of a steep and curved line, and its play comes out too broad. So each wrench is moved by the share of the residual that
its own noise explains, by s Σ sᵀ e / (σ² + s Σ sᵀ) of the prediction, and the model evaluated there (Deming's adjusted
observations; for laws that are not linear: Britt and Luecke 1973).

It is moved as the driven motor alone can change it, by the wrench that turns no other drive: what the others carried
would else hold a share of this model's residual, and a law of it would explain what the model leaves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.readings.observations import Observations, WrenchCorrection
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.clamped_inverse import RANK
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.held_frame import HeldFrame

# Standard uncertainties of its residual by which a wrench is moved at most: beyond, it is not the wrench's noise.
MOST = 3.0
# A wrench moves at least by this share of a step.
LEAST_SHARE = 0.1
# Steps that differ by less than this share show no secant.
SMALLEST_FALL = 1e-6
# Clamped states next to each other in angle over which a value is averaged: those of a few cycles, both ways.
NEIGHBOURS = 9


def wrench_correction(
    data: Observations, residual: Floats, sensitivity: Floats, chain: Chain
) -> WrenchCorrection | None:
    """Return the correction of clamped states' wrenches; None where none is known well enough.

    Parameters
    ----------
    data : the observations, m rows of n states.
    residual : (m, n) measured minus predicted with the present correction, offsets taken out, rad in the motors' rows.
    sensitivity : (m, 6, n) derivative of the prediction by the wrench.
    chain : the robot.
    """
    motors, before = data.layout.motors, data.correction
    if data.clamped is None or motors is None:
        return None
    axes = _wrench_axes(data, chain)
    turns = _turns_of_drives(data, motors.held, chain, axes)
    wrench_variance = np.where(np.isfinite(data.clamped.wrench), data.clamped.wrench, 0.0) ** 2
    known = np.isfinite(data.clamped.motor)
    wrench, rows = np.zeros_like(data.wrench), np.zeros_like(data.measured)
    proposed, relaxation = np.full(data.n_states, np.nan), np.ones(data.n_states)
    for drive, row in enumerate(motors.row):
        states = np.flatnonzero(known & data.measured_mask[row])
        slope = sensitivity[row][:, states]
        of_wrench = np.sum(slope**2 * wrench_variance[:, states], axis=0)
        sigma = np.sqrt(data.clamped.motor[states] ** 2 + of_wrench)
        share = np.clip(residual[row, states] / sigma, -MOST, MOST) / sigma
        moved = wrench_variance[:, states] * slope * share
        target = _as_one_drive(moved, turns[:, :, states], drive, wrench_variance[:, states], data.run[states])
        present = 0.0 if before is None else before.wrench[:, states]
        along = np.sum(slope * (target - present), axis=0)
        proposed[states] = np.divide(along, np.sqrt(of_wrench), out=np.zeros_like(along), where=of_wrench > 0.0)
        if before is not None:
            relaxation[states] = _relaxation(before, proposed, states)
        wrench[:, states] = present + relaxation[states] * (target - present)
        rows[row, states] = np.sum(slope * wrench[:, states], axis=0)
    held = np.concatenate([np.einsum("ijn,jn->in", axes, part) for part in (wrench[:3], wrench[3:])])
    return WrenchCorrection(wrench, held, rows, proposed, relaxation)


def _wrench_axes(data: Observations, chain: Chain) -> Floats:
    """Return (3, 3, n) the axes in which wrenches were read, base axes, each run in its mean pose."""
    _, first, number = np.unique(data.run, return_index=True, return_inverse=True)
    axes = attached_poses(chain, data.angles[:, first].T, data.setup.wrench_axes)[1]
    return np.ascontiguousarray(np.moveaxis(axes, 0, -1)[:, :, number])


def _turns_of_drives(data: Observations, held: HeldFrame, chain: Chain, axes: Floats) -> Floats:
    """Return (6, J, n) how the held frame moves with the drives, m and rad per rad, axes of the wrenches."""
    _, first, number = np.unique(data.run, return_index=True, return_inverse=True)
    jacobian = np.einsum("iln,lj->ijn", held.jacobian[:, :, first], np.linalg.inv(chain.drives_of_logged))
    parts = [np.einsum("bkn,bjn->kjn", axes[:, :, first], jacobian[rows]) for rows in (slice(0, 3), slice(3, 6))]
    return np.ascontiguousarray(np.concatenate(parts)[:, :, number])


def _as_one_drive(moved: Floats, turns: Floats, drive: int, variance: Floats, run: Integers) -> Floats:
    """Return wrenches (6, s) that change one drive's torque as others do, and no other drive's.

    Of these wrenches those of the sensor's noise: least squares in its components' uncertainties.

    Parameters
    ----------
    moved : (6, s). turns : (6, J, s) as of `_turns_of_drives`. drive : from 0. variance : (6, s) of the components.
    run : (s,) of each state.
    """
    result = moved.copy()
    for number in np.unique(run):
        states = np.flatnonzero(run == number)
        size = np.sqrt(np.mean(variance[:, states], axis=1))
        scaled = turns[:, :, states[0]] * size[:, None]
        own, others = scaled[:, drive], np.delete(scaled, drive, axis=1)
        left, values, _ = np.linalg.svd(others, full_matrices=False)
        basis = left[:, values > RANK * values[0]] if values.size else left
        alone = own - basis @ (basis.T @ own)
        if alone @ alone > (RANK**2) * (own @ own):
            torque = turns[:, drive, states[0]] @ moved[:, states]
            result[:, states] = np.outer(size * alone / (alone @ own), torque)
    return result


def _relaxation(before: WrenchCorrection, proposed: Floats, states: Integers) -> Floats:
    """Return by what share of a step each wrench moves: by the secant of the last two, as whole ones may go to and fro.

    That is Aitken's rule state by state, kept between `LEAST_SHARE` and a whole step: where a law bends sharply, the
    step along its tangent goes too far (Irons and Tuck 1969).
    """
    last, now = before.proposed[states], proposed[states]
    fall = last - now
    usable = np.isfinite(last) & (np.abs(fall) > SMALLEST_FALL * np.abs(last))
    share = np.divide(before.relaxation[states] * last, fall, out=np.ones_like(now), where=usable)
    return np.where(share > 0.0, np.clip(share, LEAST_SHARE, 1.0), 1.0)


def with_curvature(data: Observations, sensitivity: Floats, predict: Callable[[Observations], Floats]) -> Observations:
    """Return the observations with what a law's bend within the wrench's noise adds to the motors' uncertainty.

    To second order the reading's error ε moves the prediction by f′ε + ½ f″ε², whose second part has the mean square
    ¾ f″²σ⁴: of a play that is crossed within the sensor's noise hardly anything is known there.

    Parameters
    ----------
    data : the observations. sensitivity : (m, 6, n) derivative of the prediction by the wrench.
    predict : returns the rows (m, n) of observations.
    """
    if data.clamped is None:
        return data
    sigma = np.where(np.isfinite(data.clamped.wrench), data.clamped.wrench, 0.0)
    # One motor is read in a clamped state, so that all states are moved at once, each along its own motor's slope.
    rows = data.rows_of(MOTOR)
    read = np.isfinite(data.clamped.motor) & data.measured_mask[rows]
    slope = np.sum(np.where(read[:, None, :], sensitivity[rows], 0.0), axis=0)
    of_wrench = np.sqrt(np.sum((slope * sigma) ** 2, axis=0))
    along = np.divide(sigma**2 * slope, of_wrench, out=np.zeros_like(slope), where=of_wrench > 0.0)
    beyond, here, before = (
        predict(replace(data, wrench=data.wrench + sign * along))[rows] for sign in (1.0, 0.0, -1.0)
    )
    motor = data.clamped.motor.copy()
    for row, states in enumerate(read):
        bend = along_sweep(np.abs(beyond[row] + before[row] - 2.0 * here[row]), data, states)
        motor = np.where(states, np.hypot(motor, np.sqrt(0.75) * bend), motor)
    return replace(data, clamped=replace(data.clamped, motor=motor))


def along_sweep(values: Floats, data: Observations, states: Booleans) -> Floats:
    """Return values (n,) averaged over states at like motor angles, run by run."""
    motors, result = data.rows_of(MOTOR), values.copy()
    for run in np.unique(data.run[states]):
        in_run = np.flatnonzero(states & (data.run == run))
        angles = data.as_read[np.ix_(motors, in_run)]
        order = in_run[np.argsort(angles[np.argmax(np.ptp(angles, axis=1))])]
        weights = np.ones(min(NEIGHBOURS, order.size))
        summed = np.convolve(values[order], weights, mode="same")
        result[order] = summed / np.convolve(np.ones(order.size), weights, mode="same")
    return result


def step_of(correction: WrenchCorrection) -> float:
    """Return the rms of what the last step would have moved the wrenches by, in their standard uncertainties."""
    steps = correction.proposed[np.isfinite(correction.proposed)]
    return float(np.sqrt(np.mean(steps**2))) if steps.size else 0.0
