"""A force sensor whose axes are not where its frame says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.measurements.load_states import Attachment, LoadStates, Sigma
from stiffcal.mechanics.rotations import rotation_from_rpy
from stiffcal.mistakes.displacements.turned_sensor import turned_sensor
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

CHAIN = six_axes()


@pytest.fixture(scope="module")
def measured() -> LoadStates:
    return played(joint_springs(CHAIN, np.array(SIX_STIFFNESS)), noise=Sigma(translation=2e-5, rotation=1e-4), seed=4)


def stated(states: LoadStates, rpy_deg: Sequence[float]) -> LoadStates:
    """Return the states with the sensor's axes turned by so much before the turn that is true."""
    axes = states.setup.wrench_axes
    turn = np.eye(4)
    turn[:3, :3] = rotation_from_rpy(np.radians(rpy_deg))
    setup = replace(states.setup, wrench_axes=Attachment(axes.body, axes.transform @ turn))
    return replace(states, setup=setup)


@pytest.mark.parametrize("rpy_deg", [(180, 0, 0), (0, 0, 90), (0, 0, 45), (20, -70, 130)])
def test_the_turn_of_a_sensor_is_found(measured: LoadStates, rpy_deg: tuple[float, float, float]) -> None:
    found = turned_sensor(stated(measured, rpy_deg), CHAIN)
    assert found is not None
    axes = rotation_from_rpy(np.radians(found.rpy_deg))
    difference = axes.T @ measured.setup.wrench_axes.transform[:3, :3]
    assert np.degrees(np.arccos((np.trace(difference) - 1.0) / 2.0)) < 5.0


def test_a_sensor_as_it_is_stated_is_none(measured: LoadStates) -> None:
    assert turned_sensor(measured, CHAIN) is None


def test_displacements_that_follow_no_load_are_no_turned_sensor(measured: LoadStates) -> None:
    order = np.random.default_rng(2).permutation(len(measured))
    assert turned_sensor(replace(measured, wrench=measured.wrench[order]), CHAIN) is None


def test_too_few_poses_tell_nothing(measured: LoadStates) -> None:
    assert turned_sensor(stated(measured.select(measured.run < 2), (0, 0, 90)), CHAIN) is None
