"""A parameter without each group of poses, and what its scatter over the groups says."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.validation.elasticity import errors_of_groups, group_jackknife
from stiffcal.validation.heldout import estimates_without_each
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

NAME = "joint-compliance.j2.c"


def places(n_poses: int) -> tuple[CompliantRobot, LoadStates]:
    """Return a model of geometry and springs of joints 2 and 3, and places of a robot with these springs alone."""
    chain = six_axes()
    springs = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS])[1:3]
    states = measured_by(CompliantRobot(chain, tuple(springs)), absolute_states(chain, n_poses, 5), 6)
    free = on_all_joints(JointCompliance(), 6)[1:3]
    return CompliantRobot(chain, (*on_all_joints(LinkGeometry(), 6), *free)), states


def test_estimates_are_those_of_fits_without_the_group() -> None:
    """To a thousandth of a standard deviation: it is linear within what a third of the poses changes."""
    robot, states = places(60)
    fit = identify_parameters(states, robot)
    fold = np.arange(60) % 3
    found = estimates_without_each(fit, fold, NAME)
    settings = Settings(noise=fit.noise)
    refitted = [identify_parameters(states.select(fold != g), robot, settings).parameter(NAME) for g in range(3)]
    std = fit.parameter(NAME).std
    assert std is not None
    assert found == pytest.approx([parameter.value for parameter in refitted], abs=1e-3 * std)
    assert np.ptp(found) > 0.1 * std


def test_a_group_that_alone_determines_a_parameter_leaves_nothing() -> None:
    """Of two groups one holds three poses: nine coordinates for more than thirty parameters."""
    robot, states = places(40)
    found = estimates_without_each(identify_parameters(states, robot), (np.arange(40) < 37).astype(int), NAME)
    assert np.isfinite(found[0])
    assert np.isnan(found[1])
    assert group_jackknife(found, 1.0) == np.inf


def test_the_scatter_of_group_means_is_the_standard_error_of_their_mean() -> None:
    """Six groups of like size: a mean of means, of which the jackknife is exact (Efron, 1982, section 3.1)."""
    means = np.array([1.0, 2.0, 4.0, 7.0, 7.5, 9.0])
    without = (means.sum() - means) / 5.0
    assert group_jackknife(without, float(means.mean())) == pytest.approx(float(means.std(ddof=1) / np.sqrt(6.0)))
    assert group_jackknife(without[:1], 1.0) == np.inf


@pytest.mark.parametrize(("groups", "errors"), [(2, 13.97), (6, 2.65), (1000, 2.003)])
def test_few_groups_ask_for_more_standard_errors(groups: int, errors: float) -> None:
    """Student's quantile of the probability of two standard deviations (tables of t, p = 0.97725)."""
    assert errors_of_groups(groups) == pytest.approx(errors, rel=1e-3)


def test_one_group_tells_nothing() -> None:
    assert errors_of_groups(1) == np.inf
