"""One step of the correction of clamped states' wrenches, near the solution of a fit."""

from __future__ import annotations

import numpy as np

from stiffcal.estimation.triangular import Reduced
from stiffcal.identification.noise.weights import Weights, predict_observations, without_offsets
from stiffcal.identification.noise.wrench_correction import step_of, with_curvature, wrench_correction
from stiffcal.identification.readings.observations import Observations
from stiffcal.model.assembled.composite import CompliantRobot

# A model that leaves more than so many times the noise lacks something: its residual is not the wrench's.
NEAR_NOISE = 2.0


def corrected_wrenches(
    robot: CompliantRobot, data: Observations, reduced: Reduced, weights: Weights
) -> tuple[Observations, float]:
    """Return the observations with clamped states' wrenches where they lie most probably, and how far these moved.

    Parameters
    ----------
    robot : the model near its solution. data : the observations it was fitted to, with their present correction.
    reduced : the model's rows. weights : of the fit.

    Returns
    -------
    The observations, and the rms of the last step in standard uncertainties of the wrench. They stay as they were, and
    the step is 0, where the wrench is not known to be uncertain or the model leaves more than `NEAR_NOISE` times the
    noise.
    """
    if data.clamped is None or weights.sensitivity is None or not weights.carried:
        return data, 0.0
    residual = without_offsets(data, reduced.predicted, weights.whitening)
    white = weights.whitening.apply(residual)[data.measured_mask]
    if data.correction is None and float(np.mean(white**2)) > NEAR_NOISE**2:
        return data, 0.0
    if data.correction is None:
        data = with_curvature(data, weights.sensitivity, lambda moved: predict_observations(robot, moved))
    correction = wrench_correction(data, residual, weights.sensitivity, robot.adjusted_chain)
    if correction is None:
        return data, 0.0
    return data.corrected(correction), step_of(correction)
