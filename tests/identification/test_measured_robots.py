"""Units of a whole campaign show in stiffnesses that no robot of such a reach has; sound robots raise no doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.identification.answers.measured_robots import (
    KGF,
    MEASURED,
    UnusualStiffness,
    reach_of,
    unusual_stiffness,
    unusual_stiffness_warnings,
)
from stiffcal.identification.fitting.identify import identify_parameters
from tests.laboratory.hidden_campaigns import folder_of, reduced
from tests.laboratory.random_robots import DrawnRobot, draw_robot
from tests.laboratory.simulated_states import joint_springs


def looked_at(reach: float, stiffness: np.ndarray, factor: float) -> UnusualStiffness | None:
    return unusual_stiffness(reach, {joint: factor * value for joint, value in enumerate(stiffness, start=1)})


def six_axis_robots(count: int) -> list[DrawnRobot]:
    rng = np.random.default_rng(20261123)
    drawn: list[DrawnRobot] = []
    while len(drawn) < count:
        robot = draw_robot(rng)
        drawn += [robot] if robot.chain.n_joints == 6 else []
    return drawn


def test_robots_drawn_at_random_raise_no_doubt_and_nearly_all_do_in_kgf_or_inches() -> None:
    """Of 2000: 0.2 % as they are, 98 % with forces in kgf or displacements in inches."""
    robots = six_axis_robots(300)

    def share(factor: float) -> float:
        found = [looked_at(reach_of(robot.chain), robot.stiffness, factor) for robot in robots]
        return sum(one is not None for one in found) / len(found)

    assert share(1.0) <= 0.01
    assert share(1.0 / KGF) > 0.95
    assert share(25.4) > 0.95


def test_the_measured_robots_raise_no_doubt() -> None:
    for robot in MEASURED:
        known = {joint: value for joint, value in enumerate(robot.stiffness, start=1) if value is not None}
        assert unusual_stiffness(robot.reach_m, known) is None


def test_forces_in_kgf_are_named_with_the_joints() -> None:
    robot = MEASURED[1]
    unusual = looked_at(robot.reach_m, np.array(robot.stiffness, dtype=np.float64), 1.0 / KGF)
    assert unusual is not None
    assert "forces in kgf in a column of N" in unusual.units
    assert all(factor < 0.5 for factor in unusual.factors.values())


def test_of_a_reach_that_no_two_robots_were_measured_at_nothing_is_judged() -> None:
    assert looked_at(0.9, np.full(6, 1.0), 1.0) is None


def test_a_fit_of_a_campaign_in_kgf_warns_and_the_right_one_does_not() -> None:
    states = reduced("01").states
    robot = joint_springs(load_campaign(folder_of("01")).chain)
    assert unusual_stiffness_warnings(identify_parameters(states, robot)) == []
    in_kgf = replace(states, wrench=states.wrench / KGF)
    (warning,) = unusual_stiffness_warnings(identify_parameters(in_kgf, robot))
    assert "forces in kgf in a column of N" in warning
    assert "below values measured" in warning
