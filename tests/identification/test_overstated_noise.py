"""A sigma in the manifest that is larger than the scatter of the data is a warning of `identify` and `diagnose`."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.answers.document import fit_warnings
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import CompliantRobot
from tests.laboratory.absolute_places import SIGMA, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

TEXT = "times the noise that campaign.toml states: sigma is too large"


@cache
def measured() -> LoadStates:
    chain = six_axes()
    springs = [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS]
    true = CompliantRobot(chain, tuple(on_all_joints(JointCompliance(), 6, springs)))
    return measured_by(true, absolute_states(chain, 60, 5), 6)


@pytest.mark.parametrize(("stated", "warned"), [(1.0, False), (1.1, False), (1.4, True), (2.0, True)])
def test_a_stated_noise_that_is_too_large_is_a_warning(stated: float, warned: bool) -> None:
    """1.1 σ is χ² 0.83, and 1.4 σ 0.51, with ± 0.13 by chance from some 120 degrees of freedom."""
    states = measured()
    states = replace(states, setup=replace(states.setup, sigma=Sigma(translation=stated * SIGMA)))
    model = (*on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6))
    robot = CompliantRobot(six_axes(), model)
    fit = identify_parameters(states, robot)
    assert any(TEXT in line for line in fit_warnings(fit)) is warned
    answer = diagnosis_result(diagnose_states(states, robot, {}))
    assert any(TEXT in line for line in answer.warnings) is warned
