"""Expected uncertainties against the fit's own, with the geometry's tolerance."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from stiffcal.identification.fitting.geometry import geometry_columns, with_geometry
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.mechanics.chain import GeometryTolerance
from stiffcal.planning.expected import expected_fit
from stiffcal.planning.information import information_of_runs
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.simulated_states import joint_springs
from tests.laboratory.states_of_runs import states_of_runs

TOLERANCE = GeometryTolerance(5e-4, np.radians(0.02))


def test_it_is_what_the_fit_of_such_a_campaign_states() -> None:
    rng = np.random.default_rng(4)
    robot = joint_springs(replace(six_axes(), tolerance=TOLERANCE), SIX_STIFFNESS)
    setup = force_sensor_setup(robot.chain)
    joints, loads = six_axis_joints(rng, 10), 400.0 * rng.normal(size=(10, 3, 6))
    loads[:, :, 3:] *= 0.1
    noise = Noise(2e-6, 0.0, 0.05, 0.005, "manifest", np.inf)
    runs = information_of_runs(
        robot, joints, loads, setup, noise, with_rotation=False, further=partial(geometry_columns, robot)
    )
    sizes = np.tile(np.repeat([TOLERANCE.length, TOLERANCE.angle], 3), robot.chain.n_joints)
    expected = expected_fit(runs.factors, runs.further, sizes, None)
    states = states_of_runs(robot, joints, loads, setup, noise, rng)
    fit = with_geometry(identify_parameters(states, robot, Settings(noise=noise)), states)
    relative = [(parameter.std or np.nan) / (parameter.value or np.nan) for parameter in fit.parameters]
    assert expected.course[-1] == pytest.approx(relative, rel=0.03)
    assert expected.from_geometry == pytest.approx([p.from_geometry for p in fit.parameters], abs=0.03)
    # the geometry is a good part of it, otherwise this shows nothing
    assert max(expected.from_geometry) > 0.5
    # without a run: what the others alone bring
    others = np.arange(10) != 3
    left = expected_fit(runs.factors[others], runs.further[others], sizes, None)
    assert expected.without[3] == pytest.approx(left.course[-1], rel=1e-6)
