"""What drives carried in the poses before: sequences of rows, and torques of the undeformed robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.readings.pose_history import pose_history, rigid_drive_torques
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.laws.drives import drive_torque
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.robots import six_axes


def rows_that_follow(n: int) -> LoadStates:
    """Return n rows of a run whose rows follow each other, with a weight of 100 N at the tool."""
    states = absolute_states(six_axes(), n, seed=3, wrench=np.tile([0.0, 0.0, -100.0, 0.0, 0.0, 0.0], (n, 1)))
    return replace(states, runs=tuple(replace(run, direct=True) for run in states.runs))


def test_a_row_whose_load_is_unknown_ends_the_sequence() -> None:
    """As one that is missing or has no time: no load would be a load like any other."""
    states = rows_that_follow(6)
    wrench, time = states.wrench.copy(), states.time.copy()
    wrench[2, :3] = np.nan
    history = pose_history(replace(states, wrench=wrench), six_axes(), np.array([0, 1, 2, 3, 4, 5]))
    assert history is not None
    assert history.index.tolist() == [0, 1, -1, 2, 3, 4]
    assert history.segment.tolist() == [1, 1, 2, 2, 2]
    time[2] = np.nan
    other = pose_history(replace(states, time=time), six_axes(), np.array([0, 1, 2, 3, 4, 5]))
    assert other is not None
    assert other.segment.tolist() == history.segment.tolist()
    np.testing.assert_array_equal(history.torque, other.torque)


@pytest.mark.parametrize("coupled", [False, True])
def test_torques_are_those_of_the_drives_at_rest(coupled: bool) -> None:
    """What effects get of a rigid robot at rest; with a parallel rod drive 2 turns joint 3 too."""
    chain = six_axes()
    if coupled:
        coupling = np.eye(6)
        coupling[2, 1] = -1.0
        chain = replace(chain, coupling=coupling, mechanical=np.arange(6) == 2)
    states = rows_that_follow(8)
    carried = Linearised.about(CompliantRobot(chain, ()), observe(states, chain)).loads.wrench
    found = rigid_drive_torques(chain, states.joints, states.wrench, states.setup)
    assert np.abs(found[1]).max() > 10.0
    for joint in range(1, 7):
        # N·m, of some thousand
        np.testing.assert_allclose(found[joint - 1], drive_torque(chain, carried, joint), atol=1e-7)
    # potential energy of the payload: the rod leaves drive 2 what turns links 2 and 3 at once
    assert bool(np.allclose(found[1], drive_torque(six_axes(), carried, 2))) is not coupled
