"""Campaigns with no more readings than the model has values."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.catalogue.catalogue import find_effects
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


def test_no_more_readings_than_values_are_one_line() -> None:
    """Nothing is left over that could show a missing effect; the judgement neither divides by it nor names one."""
    load = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [200.0, 300.0, -400.0, 0.0, 0.0, 0.0]])
    states = played(medium_robot(), runs=1, wrench=[load], noise=Sigma(16e-6, 30e-6), full_pose=False)
    with pytest.raises(InputError, match="readings for") as error:
        diagnose_states(states, joint_springs(six_axes()), find_effects())
    assert error.value.code is FaultCode.DATA_MISSING
