"""Readings set aside: no observation, but the load was there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.validation.validate import validate_fit
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


def with_friction(robot: CompliantRobot, **values: float) -> CompliantRobot:
    """Return the robot with friction in joint 2."""
    one = PlacedEffect(find_effects()["friction-hysteresis"], Place("joints", (2,)), values)
    return replace(robot, placed=(*robot.placed, one))


@pytest.fixture(scope="module")
def states() -> LoadStates:
    """A campaign with friction; every second peak's reading is bumped by half a millimetre and set aside."""
    made = played(with_friction(medium_robot(), c=3e-7, slip=60.0), runs=4)
    force = np.linalg.norm(made.wrench[:, :3], axis=1)
    peaks = np.flatnonzero(force > 0.9 * force.max())[::2]
    position = made.position.copy()
    position[peaks] += 5e-4
    return replace(made, position=position).with_set_aside(peaks, SetAsideCode.BUMPED, "off its repeats")


def test_friction_goes_through_the_load_of_a_bumped_reading(states: LoadStates) -> None:
    """The peaks are turning points of the play: were they left out, the friction would come out wrong."""
    fit = identify_parameters(states, with_friction(joint_springs(six_axes())))
    assert fit.parameter("friction-hysteresis.j2.c").value == pytest.approx(3e-7, rel=1e-3)
    assert fit.parameter("friction-hysteresis.j2.slip").value == pytest.approx(60.0, rel=1e-3)
    assert fit.data.n_measured == np.count_nonzero(states.used) < len(states)


def test_bumped_readings_do_not_count(states: LoadStates) -> None:
    """Neither in the error nor in how many states it was taken over."""
    fit = identify_parameters(states, with_friction(joint_springs(six_axes())))
    validation = validate_fit(states, fit)
    assert validation.rms.translation == pytest.approx(0.0, abs=1e-6)
    assert sum(part.n for part in validation.by["run"]) == np.count_nonzero(states.used)


def test_what_the_manifest_excludes_is_no_load(states: LoadStates) -> None:
    """A state excluded by the user is out as a whole."""
    excluded = states.with_set_aside(~states.used, SetAsideCode.EXCLUDED, "cable slipped")
    fit = identify_parameters(excluded, joint_springs(six_axes()))
    assert fit.data.n_states == np.count_nonzero(states.used)
