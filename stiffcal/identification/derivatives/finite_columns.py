"""A derivative that is no finite number is an error that names its parameter, before the least squares meet it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.assembled.composite import CompliantRobot


def check_finite(derivatives: Floats, robot: CompliantRobot, parameters: Sequence[tuple[int, str]]) -> None:
    """Check (p, m, n) derivatives of the observations.

    Parameters
    ----------
    derivatives : by the parameters.
    robot : the model.
    parameters : p numbers of placed effects, each with a symbol.

    Raises
    ------
    InputError : one is not finite: a law that is evaluated where it has no value.
    """
    if np.isfinite(derivatives).all():
        return
    number = int(np.flatnonzero(~np.isfinite(derivatives).all(axis=(1, 2)))[0])
    placed, symbol = robot.placed[parameters[number][0]], parameters[number][1]
    reason = f"the derivative by {placed.parameter_name(symbol)} is not a finite number"
    mend = "give it another start value, or check the law of the effect at this value"
    raise InputError.at(FaultCode.MODEL_UNSUITABLE, "model.toml", "effects", reason, mend)
