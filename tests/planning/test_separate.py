"""Which pose and load two models disagree on most: within reach of the robot, with loads of the campaign."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import Balance, NoBalanceError, solve_balance
from stiffcal.planning import separate
from stiffcal.planning.rivals import RivalModel
from stiffcal.planning.separate import POSES, ChosenMeasurement, KnownPair, separating_measurement
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes
from tests.laboratory.simulated_states import joint_springs

# two poses, deg: joint 1 spans 90°, joint 6 hardly moves
MEASURED = np.radians([[-30.0, -70.0, 20.0, 15.0, 40.0, 10.0], [60.0, -95.0, 35.0, -60.0, 55.0, 12.0]])
# unloaded, then the largest along and against each axis, each with a moment of its own, and smaller ones
WRENCH = np.array([
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [300.0, 5.0, 5.0, 1.0, 2.0, 3.0],
    [-310.0, 5.0, 5.0, 4.0, 5.0, 6.0],
    [100.0, 320.0, 5.0, 7.0, 8.0, 9.0],
    [5.0, -330.0, 5.0, 10.0, 11.0, 12.0],
    [5.0, 5.0, 340.0, 13.0, 14.0, 15.0],
    [5.0, 5.0, -350.0, 16.0, 17.0, 18.0],
    [50.0, 60.0, 70.0, 90.0, 90.0, 90.0],
])  # fmt: skip
NOISE = 2e-5


class Recorded:
    """The balances that were asked for, as `solve_balance` solves them.

    Attributes
    ----------
    joints : model angles of the last call. wrench : its wrenches.
    """

    def __init__(self) -> None:
        self.joints: Floats = np.zeros((0, 6))
        self.wrench: Floats = np.zeros((0, 6))

    def __call__(self, robot: CompliantRobot, joints: Floats, wrench: Floats, setup: MeasurementSetup) -> Balance:
        self.joints, self.wrench = joints, wrench
        return solve_balance(robot, joints, wrench, setup)


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> Recorded:
    recorded = Recorded()
    monkeypatch.setattr(separate, "solve_balance", recorded)
    return recorded


def limited(**limits_deg: tuple[float, float]) -> Chain:
    """Return the medium robot with limits of some joints, by name."""
    chain = six_axes()
    limits = chain.limits.copy()
    for name, limit in limits_deg.items():
        limits[chain.joint_names.index(name)] = np.radians(limit)
    return Chain(**{**vars(chain), "limits": limits})


def softer(chain: Chain, joint: int) -> CompliantRobot:
    """Return the robot with one joint, from 1, ten per cent softer."""
    stiffness = SIX_STIFFNESS.copy()
    stiffness[joint - 1] *= 0.9
    return joint_springs(chain, stiffness)


def separation(chain: Chain, joint: int = 2, **arguments: Any) -> ChosenMeasurement:
    """Return what separates the robot from one with a softer joint."""
    found = separating_measurement(
        joint_springs(chain, SIX_STIFFNESS), softer(chain, joint), force_sensor_setup(chain), MEASURED, WRENCH,
        **{"noise": NOISE, **arguments},
    )  # fmt: skip
    assert found is not None
    return found


def logged(recorded: Recorded, chain: Chain) -> Floats:
    """Return the distinct logged angles that were tried, deg; the robot's joints are not coupled."""
    return np.unique(np.degrees(recorded.joints - chain.offset).round(9), axis=0)


def test_poses_fill_the_limits_and_nothing_beyond(recorded: Recorded) -> None:
    chain = limited(A1=(-100.0, 20.0), A4=(30.0, 50.0))
    separation(chain)
    poses = logged(recorded, chain)
    assert len(poses) == POSES
    for joint, low, high in ((0, -100.0, 20.0), (3, 30.0, 50.0)):
        drawn, span = poses[:, joint], high - low
        assert low <= drawn.min() < low + 0.02 * span
        assert high - 0.02 * span < drawn.max() <= high
        assert np.mean(drawn) == pytest.approx(0.5 * (low + high), abs=0.06 * span)


def test_without_limits_poses_go_a_third_beyond_what_was_measured(recorded: Recorded) -> None:
    chain = six_axes()
    separation(chain)
    poses = logged(recorded, chain)
    # joint 1 was measured from -30° to 60°; joint 6 from 10° to 12°, which is widened by ten degrees at least
    for joint, low, high in ((0, -60.0, 90.0), (5, 0.0, 22.0)):
        drawn, span = poses[:, joint], high - low
        assert low <= drawn.min() < low + 0.02 * span
        assert high - 0.02 * span < drawn.max() <= high


def test_a_limit_on_one_side_alone_holds_that_side(recorded: Recorded) -> None:
    chain = limited(A1=(-40.0, np.inf), A2=(-np.inf, -80.0))
    separation(chain)
    poses = logged(recorded, chain)
    assert -40.0 <= poses[:, 0].min() < -37.0
    assert 87.0 < poses[:, 0].max() <= 90.0
    assert -105.0 <= poses[:, 1].min() < -104.0
    assert -81.0 < poses[:, 1].max() <= -80.0


def test_every_pose_is_tried_with_the_largest_loads_of_the_campaign(recorded: Recorded) -> None:
    chain = six_axes()
    separation(chain)
    assert len(recorded.joints) == 6 * POSES
    for number in (0, 1, POSES - 1):
        same_pose = slice(6 * number, 6 * number + 6)
        assert np.ptp(recorded.joints[same_pose], axis=0).max() == 0.0
        np.testing.assert_array_equal(recorded.wrench[same_pose], WRENCH[1:7])


def test_no_other_measurement_that_was_tried_separates_more(recorded: Recorded) -> None:
    chain = six_axes()
    found = separation(chain)
    setup = force_sensor_setup(chain)
    moved = [
        solve_balance(robot, recorded.joints, recorded.wrench, setup).displacement[:, 0, :3]
        for robot in (joint_springs(chain, SIX_STIFFNESS), softer(chain, 2))
    ]
    apart = np.linalg.norm(moved[0] - moved[1], axis=1)
    assert found.difference == pytest.approx(apart.max(), rel=1e-9)
    best = int(np.argmax(apart))
    np.testing.assert_array_equal(found.joints + chain.offset, recorded.joints[best])
    np.testing.assert_array_equal(found.wrench, recorded.wrench[best])
    assert found.gain == pytest.approx(found.difference / NOISE)


def test_the_softer_joint_is_turned_by_the_load_that_separates() -> None:
    """Two models that differ in one joint alone differ by what this joint's torque makes of it: a long lever."""
    chain = six_axes()
    found = separation(chain, joint=6)
    robot = joint_springs(chain, SIX_STIFFNESS)
    setup = force_sensor_setup(chain)
    balance = solve_balance(robot, chain.model_angles(found.joints[None]), found.wrench[None], setup)
    other = solve_balance(softer(chain, 6), chain.model_angles(found.joints[None]), found.wrench[None], setup)
    apart = np.linalg.norm(balance.displacement[0, 0, :3] - other.displacement[0, 0, :3])
    assert found.difference == pytest.approx(float(apart), rel=1e-9)
    assert 0.0 < found.difference < separation(chain, joint=2).difference


def test_without_noise_the_gain_has_no_end() -> None:
    assert separation(six_axes(), noise=0.0).gain == np.inf


def test_the_seed_chooses_the_poses() -> None:
    first, again, other = (separation(six_axes(), seed=seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first.joints, again.joints)
    assert not np.allclose(first.joints, other.joints)
    np.testing.assert_array_equal(first.joints, separation(six_axes()).joints)


def test_models_without_a_balance_are_not_separated(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> Balance:
        raise NoBalanceError("no balance")

    monkeypatch.setattr(separate, "solve_balance", none)
    chain = six_axes()
    robots = joint_springs(chain, SIX_STIFFNESS), softer(chain, 2)
    assert separating_measurement(*robots, force_sensor_setup(chain), MEASURED, WRENCH, NOISE) is None


def test_what_a_refit_takes_up_separates_nothing() -> None:
    """Two values of one stiffness: data that fix them leave the difference, a refit without data takes all of it up."""
    chain = six_axes()
    robots = joint_springs(chain, SIX_STIFFNESS), softer(chain, 2)
    noise = Noise(NOISE, 0.0, 0.0, 0.0, "manifest", np.inf)
    gains = []
    for relative in (1e-4, 10.0):
        rivals = [
            RivalModel.of_covariance(
                robot,
                {
                    name: {n: (relative * size) ** 2 * (n == name) for n in robot.values()}
                    for name, size in robot.values().items()
                },
            )
            for robot in robots
        ]
        known = KnownPair(rivals[0], rivals[1], noise, False, frozenset())
        found = separation(chain, known=known)
        assert found.difference <= separation(chain).difference * (1.0 + 1e-9)
        gains.append(found.gain)
    # an unloaded reading and one more come with the loaded one: the noise of their mean counts
    assert gains[0] == pytest.approx(separation(chain).difference / NOISE * np.sqrt(2.0 / 3.0), rel=0.05)
    assert gains[1] < 0.02 * gains[0]
