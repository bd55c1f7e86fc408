"""Where the wrench of a clamped state lies most probably, given the motor's angle (errors in variables).

In a play the angle rises by its whole width within a torque that the sensor may hardly resolve. There the angle shows
the torque better than the sensor does: a model that is evaluated at the torque as read is compared at the wrong place
of a steep and curved line, and its play comes out too broad. So each wrench is moved by the share of the residual that
its own noise explains, δ = Σ sᵀ e / (σ² + s Σ sᵀ), and the model evaluated there (Deming's adjusted observations; for
laws that are not linear: Britt and Luecke 1973).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.readings import Observations, WrenchCorrection
from stiffcal.identification.row_layout import MOTOR

# Standard uncertainties of its residual by which a wrench is moved at most: beyond, it is not the wrench's noise.
MOST = 3.0
# A wrench moves at least by this share of a step.
LEAST_SHARE = 0.1
# Steps that differ by less than this share show no secant.
SMALLEST_FALL = 1e-6
# Clamped states next to each other in angle over which a value is averaged: those of a few cycles, both ways.
NEIGHBOURS = 9


def wrench_correction(data: Observations, residual: Floats, sensitivity: Floats) -> WrenchCorrection | None:
    """Return the correction of clamped states' wrenches; None where none is known well enough.

    Parameters
    ----------
    data : the observations, m rows of n states.
    residual : (m, n) measured minus predicted with the present correction, offsets taken out, rad in the motors' rows.
    sensitivity : (m, 6, n) derivative of the prediction by the wrench.
    """
    if data.clamped is None:
        return None
    motors, before = data.rows_of(MOTOR), data.correction
    wrench_variance = np.where(np.isfinite(data.clamped.wrench), data.clamped.wrench, 0.0) ** 2
    known = np.isfinite(data.clamped.motor)
    wrench, rows = np.zeros_like(data.wrench), np.zeros_like(data.measured)
    proposed, relaxation = np.full(data.n_states, np.nan), np.ones(data.n_states)
    for row in motors:
        states = np.flatnonzero(known & data.measured_mask[row])
        slope = sensitivity[row][:, states]
        of_wrench = np.sum(slope**2 * wrench_variance[:, states], axis=0)
        sigma = np.sqrt(data.clamped.motor[states] ** 2 + of_wrench)
        share = np.clip(residual[row, states] / sigma, -MOST, MOST) / sigma
        target = wrench_variance[:, states] * slope * share
        present = 0.0 if before is None else before.wrench[:, states]
        along = np.sum(slope * (target - present), axis=0)
        proposed[states] = np.divide(along, np.sqrt(of_wrench), out=np.zeros_like(along), where=of_wrench > 0.0)
        if before is not None:
            relaxation[states] = _relaxation(before, proposed, states)
        wrench[:, states] = present + relaxation[states] * (target - present)
        rows[row, states] = np.sum(slope * wrench[:, states], axis=0)
    return WrenchCorrection(wrench, rows, proposed, relaxation)


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
