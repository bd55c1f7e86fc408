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

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.readings import Observations, WrenchCorrection
from stiffcal.identification.rows import MOTOR

# Standard uncertainties of its residual by which a wrench is moved at most: beyond, it is not the wrench's noise.
MOST = 3.0
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
    motors = data.rows_of(MOTOR)
    wrench_variance = np.where(np.isfinite(data.clamped.wrench), data.clamped.wrench, 0.0) ** 2
    known = np.isfinite(data.clamped.motor)
    wrench, rows = np.zeros_like(data.wrench), np.zeros_like(data.measured)
    for row in motors:
        states = np.flatnonzero(known & data.measured_mask[row])
        slope = sensitivity[row][:, states]
        of_wrench = np.sum(slope**2 * wrench_variance[:, states], axis=0)
        sigma = np.sqrt(data.clamped.motor[states] ** 2 + of_wrench)
        share = np.clip(residual[row, states] / sigma, -MOST, MOST) / sigma
        wrench[:, states] = wrench_variance[:, states] * slope * share
        rows[row, states] = np.sum(slope * wrench[:, states], axis=0)
    return WrenchCorrection(wrench, rows)


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
    motor = data.clamped.motor.copy()
    here = predict(data)
    for row in data.rows_of(MOTOR):
        states = np.isfinite(motor) & data.measured_mask[row]
        slope = np.where(states, sensitivity[row], 0.0)
        of_wrench = np.sqrt(np.sum((slope * sigma) ** 2, axis=0))
        along = np.divide(sigma**2 * slope, of_wrench, out=np.zeros_like(slope), where=of_wrench > 0.0)
        beyond, before = (predict(replace(data, wrench=data.wrench + sign * along))[row] for sign in (1.0, -1.0))
        bend = along_sweep(np.abs(beyond + before - 2.0 * here[row]), data, states)
        motor = np.where(states, np.hypot(motor, np.sqrt(0.75) * bend), motor)
    return replace(data, clamped=replace(data.clamped, motor=motor))


def along_sweep(values: Floats, data: Observations, states: Booleans) -> Floats:
    """Return values (n,) averaged over states at like motor angles, run by run."""
    motors, result = data.rows_of(MOTOR), values.copy()
    for run in np.unique(data.run[states]):
        in_run = np.flatnonzero(states & (data.run == run))
        angles = data.measured[np.ix_(motors, in_run)]
        order = in_run[np.argsort(angles[np.argmax(np.ptp(angles, axis=1))])]
        weights = np.ones(min(NEIGHBOURS, order.size))
        summed = np.convolve(values[order], weights, mode="same")
        result[order] = summed / np.convolve(np.ones(order.size), weights, mode="same")
    return result


def step_of(before: WrenchCorrection | None, after: WrenchCorrection, data: Observations) -> float:
    """Return the rms change of a correction, in standard uncertainties of the wrench."""
    if data.clamped is None:
        return 0.0
    change = after.wrench - (0.0 if before is None else before.wrench)
    sigma = data.clamped.wrench
    known = np.isfinite(sigma) & (sigma > 0.0)
    relative = np.divide(change, sigma, out=np.zeros_like(change), where=known)
    corrected = known.any(axis=0)
    squares = np.sum(relative[:, corrected] ** 2, axis=0)
    return float(np.sqrt(np.mean(squares))) if squares.size else 0.0
