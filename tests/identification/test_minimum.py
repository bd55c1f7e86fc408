"""The estimate is the least weighted sum of squares under the weights of the model where it ends, whatever it lacks."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation import evaluate
from stiffcal.identification.fitting.identify import Settings, fit_problem, identify_parameters, offset_free_residual
from stiffcal.identification.noise.weights import estimate_weights
from stiffcal.measurements.load_states import Sigma
from tests.estimation.test_shortened_step import with_plays
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

# Of a standard uncertainty: a last step of the fit is shorter.
CLOSE = 1e-3


@pytest.mark.parametrize("play", [False, True], ids=["complete", "lacking a play"])
def test_no_other_values_leave_less(play: bool) -> None:
    """Of scipy's solver, with differences of the whole balance as its derivatives.

    With columns of first order joint 4 ends 0.01 standard uncertainties away, without the play joint 6 0.3.
    """
    true = joint_springs(six_axes(), np.array(SIX_STIFFNESS) / 2.0)
    true = with_plays(true, ("backlash", 2, True)) if play else true
    states = played(true, runs=4, noise=Sigma(20e-6, 30e-6, 0.5, 0.3), seed=3)
    model = joint_springs(six_axes())
    fit = identify_parameters(states, model)
    whitening = fit.whitening
    assert whitening is not None
    assert fit.noise is not None
    names = [parameter.name for parameter in fit.parameters]
    start = np.array([parameter.value or 0.0 for parameter in fit.parameters])
    std = np.array([parameter.std or 0.0 for parameter in fit.parameters])
    # the weights belong to the model where it ended
    problem = fit_problem(states, model)
    blocks = list(evaluate(fit.robot, fit.data, (), with_sensitivity=True))
    weights = estimate_weights(fit.data, blocks, problem.groups, problem.stated, Settings().noise, equal=False)
    np.testing.assert_allclose(weights.whitening.scale, whitening.scale, rtol=1e-4)

    def white(move: Floats) -> Floats:
        robot = fit.robot.with_values(dict(zip(names, (start + std * move).tolist(), strict=True)))
        return whitening.apply(offset_free_residual(robot, fit.data, whitening)).ravel()

    found = least_squares(white, np.zeros(6), jac="3-point", diff_step=[1e-2], x_scale=1.0, xtol=1e-12, ftol=1e-14)
    assert np.abs(found.x).max() < CLOSE
