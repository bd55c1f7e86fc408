"""Where the wrench of a state lies most probably, given what moved under it (errors in variables).

In a play the angle rises by its whole width within a torque that the sensor may hardly resolve. There the displacement
shows the torque better than the sensor does: a model that is evaluated at the wrench as read is compared at the wrong
place of a steep and curved line, and its play comes out too broad. So each wrench is moved by the share of the residual
e that its own noise explains, δ = Σ Sᵀ V⁻¹ e with V the covariance of the state's readings, and the model evaluated
there (Deming's adjusted observations; for laws that are not linear: Britt and Luecke 1973). Where no law bends, it
changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.noise import Noise, Whitening
from stiffcal.identification.readings import Observations, WrenchCorrection
from stiffcal.identification.row_layout import MOTOR

# Standard uncertainties of its residual by which a wrench is moved at most: beyond, it is not the wrench's noise.
MOST = 3.0
# Corrections after which wrenches move by less and less.
WHOLE_PASSES = 5
# Clamped states next to each other in angle over which a value is averaged: those of a few cycles, both ways.
NEIGHBOURS = 9


def wrench_correction(
    data: Observations, residual: Floats, sensitivity: Floats, noise: Noise, whitening: Whitening
) -> WrenchCorrection:
    """Return the correction of the states' wrenches.

    Parameters
    ----------
    data : the observations, m rows of n states.
    residual : (m, n) measured minus predicted with the present correction, offsets taken out, m and rad.
    sensitivity : (m, 6, n) derivative of the prediction by the wrench.
    noise : of the instruments. whitening : of the readings, the wrench's noise carried.
    """
    before, sigma = data.correction, noise.of_wrenches(data)
    sensitivity = np.where(data.measured_mask[:, None], sensitivity, 0.0)
    white = np.clip(whitening.apply(np.where(data.measured_mask, residual, 0.0)), -MOST, MOST)
    carried = np.stack([np.sum(whitening.apply(sensitivity[:, k]) * white, axis=0) for k in range(6)])
    present = np.zeros_like(data.wrench) if before is None else before.wrench
    step = sigma**2 * carried - present
    proposed = np.divide(step, sigma, out=np.zeros_like(step), where=sigma > 0.0)
    relaxation = np.ones(data.n_states) if before is None else _relaxation(before, proposed)
    wrench, passes = present + relaxation * step, 1 if before is None else before.passes + 1
    return WrenchCorrection(wrench, np.einsum("mkn,kn->mn", sensitivity, wrench), proposed, relaxation, passes)


def _relaxation(before: WrenchCorrection, proposed: Floats) -> Floats:
    """Return by what share of a step each wrench moves: half of the last share where it would go back, else twice.

    At a corner of a law the tangents of both sides send a wrench to and fro; in a curved stretch whole steps converge.
    After `WHOLE_PASSES` none moves by more than half of the largest share before: what parameters and wrenches at a
    corner do to each other ends there.
    """
    back = np.sum(before.proposed * proposed, axis=0) < 0.0
    share = np.where(back, 0.5 * before.relaxation, np.minimum(1.0, 2.0 * before.relaxation))
    most = 1.0 if before.passes < WHOLE_PASSES else 0.5 ** (before.passes - WHOLE_PASSES + 1)
    return np.asarray(np.minimum(share, most))


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
    """Return what the last step moved the wrenches by, in their standard uncertainties: of the one that moved most.

    Few of many states are inside a play, and only what these do matters.
    """
    squares = np.sum((correction.relaxation * correction.proposed) ** 2, axis=0)
    return float(np.sqrt(squares.max(initial=0.0)))
