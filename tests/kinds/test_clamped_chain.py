"""The closed chain of motors, drives and fixture: what of a motor's motion its own drive takes up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.kinds.clamped.held.chain import ClampedChain, clamped_chain, drive_deflection
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw
from stiffcal.measurements.load_states import Attachment, MeasurementSetup, RunInfo
from stiffcal.mechanics.kinematics import attached_poses, jacobians

ROBOT = Path(__file__).parents[2] / "campaigns" / "kr125" / "robot.toml"
CHAIN = chain_of(load_robot(ROBOT), ROBOT.parent)
HELD = Attachment(7, np.eye(4))
SETUP = MeasurementSetup(HELD, HELD, (), (), moments_measured=True)
STIFFNESS = np.array([1e6, 1.2e6, 7e5, 1.3e5, 1e5, 5e4])


def law(stiffness: float) -> TorqueAngleLaw:
    return TorqueAngleLaw(0.0, 0.0, 1.0, 0.0, 0.0, 0.0, (stiffness, 0.0, 0.0), (-0.01, 0.01))


def driven(pose: list[float], joint: int, fixture: Floats | None = None) -> tuple[ClampedChain, Floats]:
    """Return a linear robot, one motor driven, as a run in drive coordinates, and its drives' true give (n, J)."""
    angles = CHAIN.model_angles(np.deg2rad([pose]))
    jacobian = jacobians(CHAIN, angles, HELD)[0]
    motion = np.zeros((9, 6))
    motion[:, joint - 1] = np.linspace(0.0, 1e-3, 9)
    # J (d + K⁻¹ Jᵀ W) + C W = 0
    give = jacobian @ np.diag(1.0 / STIFFNESS) @ jacobian.T + (np.zeros((6, 6)) if fixture is None else fixture)
    wrench = -(motion @ CHAIN.coupling.T @ jacobian.T) @ np.linalg.pinv(give, rcond=1e-12).T
    turned = attached_poses(CHAIN, angles, HELD)[1][0]
    read = np.concatenate([wrench[:, :3] @ turned, wrench[:, 3:] @ turned], axis=1)
    readings = ClampedReadings(
        (RunInfo("a", "clamped"),), np.zeros(9, dtype=np.int64), np.arange(9.0), np.deg2rad(pose) + motion, read,
        np.full((9, 6), np.nan), np.array([False]),
    )  # fmt: skip
    chain = clamped_chain(readings, joint, CHAIN, SETUP, np.deg2rad(np.array(pose, dtype=np.float64)), fixture)
    return chain, (wrench @ jacobian) / STIFFNESS


@pytest.mark.parametrize("joint", range(1, 7))
def test_each_drive_takes_up_its_own_motor(joint: int) -> None:
    chain, give = driven([39, -67.5, 94.5, -37, -36.5, -49], joint)
    assert chain.is_distinguishable
    np.testing.assert_allclose(chain.angle({}) - chain.angle({})[0], give[:, joint - 1], atol=1e-12)
    np.testing.assert_allclose(chain.torque[:, joint - 1], STIFFNESS[joint - 1] * give[:, joint - 1], atol=1e-6)


def test_the_fixtures_give_is_taken_off() -> None:
    soft = np.diag([3e-7, 2e-7, 4e-7, 3e-7, 5e-7, 2e-7])
    chain, give = driven([39, -67.5, 94.5, -37, -36.5, -49], 3, soft)
    np.testing.assert_allclose(chain.angle({}) - chain.angle({})[0], give[:, 2], atol=1e-12)
    # one lever alone would count the fixture's give as the joint's
    assert np.ptp(chain.motion[:, 2]) > 1.02 * np.abs(give[-1, 2])


def test_joints_in_one_line_are_recognised_by_the_others_curve() -> None:
    """Joint 5 at zero: joints 4 and 6 turn the flange alike (004's doubt about joint 4)."""
    chain, give = driven([10, -70, 100, 30, 0, 20], 4)
    assert not chain.is_distinguishable
    assert chain.is_excited
    # taken alone, joint 4 seems as soft as both springs in series
    np.testing.assert_allclose(chain.torque[:, 3], chain.torque[:, 5], rtol=1e-6, atol=1e-9)
    alone = chain.angle({})
    own = chain.angle({6: law(STIFFNESS[5])})
    np.testing.assert_allclose(own - own[0], give[:, 3], atol=1e-9)
    assert abs(alone[-1]) > 1.3 * abs(give[-1, 3])
    assert chain.share_of_others({6: law(STIFFNESS[5])}) > 0.2


def test_give_of_a_law() -> None:
    with_play = TorqueAngleLaw(0.2, 2e-3, 0.5, 0.0, 0.0, 0.0, (1e5, 0.0, 0.0), (-0.01, 0.01))
    np.testing.assert_allclose(drive_deflection(with_play, np.array([-100.0, 100.0])), [-2e-3, 2e-3], atol=1e-7)
