"""A joint that only the force sensor's noise turns is not determined; nor does a load that turns it well get lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.estimation.undetermined import Undetermined
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates, Sigma
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import cycles_of, joint_springs, played

NOISE = Sigma(translation=15e-6, rotation=2e-5, force=1.0, moment=0.5)
SIXTH = "joint-compliance.j6.c"


def campaign(levered: bool) -> LoadStates:
    """Return states of forces through the last axis, or next to it: the sensor's origin lies on that axis."""
    rng = np.random.default_rng(4)
    wrench = [cycles_of(np.linalg.qr(rng.normal(size=(3, 3)))[0], cycles=4) for _ in range(6)]
    if not levered:
        for one in wrench:
            one[:, 3:] = 0.0
    return played(joint_springs(six_axes(), SIX_STIFFNESS), wrench=wrench, noise=NOISE)


@pytest.mark.parametrize("stated", [True, False])
def test_forces_through_the_axis(stated: bool) -> None:
    states = campaign(levered=False)
    if not stated:
        states = replace(states, setup=replace(states.setup, sigma=Sigma()))
    fit = identify_parameters(states, joint_springs(six_axes()))
    assert fit.parameter(SIXTH).value is None
    assert [one.names for one in fit.ambiguities if one.cause is Undetermined.WRENCH_NOISE] == [(SIXTH,)]
    for one, true in zip(fit.parameters[:5], SIX_STIFFNESS, strict=False):
        assert one.value is not None
        assert one.std is not None
        assert abs(one.value - 1.0 / true) < 4.0 * one.std


def test_forces_next_to_the_axis() -> None:
    fit = identify_parameters(campaign(levered=True), joint_springs(six_axes()))
    sixth = fit.parameter(SIXTH)
    assert not fit.ambiguities
    assert sixth.value is not None
    assert sixth.std is not None
    assert abs(sixth.value - 1.0 / SIX_STIFFNESS[5]) < 4.0 * sixth.std
