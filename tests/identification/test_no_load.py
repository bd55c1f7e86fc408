"""Set-up effects of the wrench have no regressor in absolute places without a load."""

from __future__ import annotations

import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.load_point_offset import LoadPointOffset
from stiffcal.effects.wrench_frame import WrenchFrame
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect, Place
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes


@pytest.mark.parametrize("effect", [LoadPointOffset(), WrenchFrame()], ids=lambda effect: effect.name)
def test_no_load_no_regressor(effect: Effect) -> None:
    """Both ends of the difference are solved alike, so that it is zero and no rounding of a solver."""
    chain = six_axes()
    springs = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS])
    states = measured_by(CompliantRobot(chain, tuple(springs)), absolute_states(chain, 40, 2), 3)
    fit = identify_parameters(states, CompliantRobot(chain, tuple(on_all_joints(JointCompliance(), 6))))
    state = Linearised.about(fit.robot, fit.data)
    assert state.regressor(effect, Place("setup"), {}).symbols == ()
