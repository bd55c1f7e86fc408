"""Simulated campaigns whose robot is MuJoCo: load states in memory, with the truth next to them.

What a campaign meets: random poses inside the working range, weights of links and tool, loads that are never hit
exactly, noise on the wrench and on the tracker, a robot whose absolute place is off by some tenths of a millimetre in
every pose (each run's free offset), position only or full pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.chain import Chain
from tests.laboratory.mujoco_robot import MujocoRobot, Spring
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.unread_states import unread_states

NOISE = Sigma(translation=16e-6, rotation=30e-6, force=0.7, moment=0.2)
"""Per state and axis: the digitizer of Wang, Zhang, Fuhlbrigge 2009 (±0.016 mm); a 3 kN six-axis force sensor."""

LEVELS = (1 / 3, 2 / 3, 1.0, 2 / 3, 1 / 3, 0.0)
"""One cycle up and down, in parts of the direction's largest load; every run starts unloaded."""


@dataclass(frozen=True)
class Plan:
    """What is measured.

    Attributes
    ----------
    poses : runs of the campaign.
    directions, cycles : per run; a cycle has the six states of `LEVELS`.
    full_pose : True where orientation is measured too.
    sigma_stated : True where the manifest says the instruments' noise; else it is left to repeats.
    force, moment : N and N·m, largest loads, drawn per direction up to these.
    """

    poses: int = 12
    directions: int = 3
    cycles: int = 2
    full_pose: bool = True
    sigma_stated: bool = True
    force: float = 500.0
    moment: float = 40.0


@dataclass(frozen=True)
class SimulatedCampaign:
    """Readings, and the truth behind them.

    Attributes
    ----------
    chain, states : as stiffcal takes them.
    joint_compliance : (6,) rad/(N·m), the truth.
    """

    chain: Chain
    states: LoadStates
    joint_compliance: Floats


def simulate_campaign(rng: np.random.Generator, plan: Plan, springs: tuple[Spring, ...] = ()) -> SimulatedCampaign:
    """Measure a robot of random stiffness, some 30 % about the published one, as planned.

    Parameters
    ----------
    springs : what gives way besides the drives.
    """
    chain = six_axes()
    setup = force_sensor_setup(chain, 12.0, (0.01, -0.02, 0.09))
    stiffness = SIX_STIFFNESS * np.exp(0.3 * rng.normal(size=6))
    angles, loads = _loads(rng, plan)
    run = np.repeat(np.arange(plan.poses), loads.shape[1])
    robot = MujocoRobot(chain, stiffness, setup, springs)
    settled = robot.settle(chain.model_angles(angles[run]), loads.reshape(-1, 6))
    n = len(run)
    offset = rng.normal(size=(plan.poses, 3)) * 3e-4
    turn = rng.normal(size=(plan.poses, 3)) * 2e-4
    tracker = np.array([NOISE.translation, NOISE.rotation], dtype=np.float64)
    position = settled.position[:, 0] + offset[run] + tracker[0] * rng.normal(size=(n, 3))
    rotation = np.full((n, 3, 3), np.nan)
    if plan.full_pose:
        rotation = turn_by(tracker[1] * rng.normal(size=(n, 3))) @ turn_by(turn[run]) @ settled.rotation[:, 0]
    sensor = np.repeat(np.array([NOISE.force, NOISE.moment], dtype=np.float64), 3)
    setup = replace(setup, sigma=NOISE if plan.sigma_stated else Sigma())
    planned = unread_states(angles, loads, setup)
    states = replace(
        planned,
        time=np.arange(0.0, 8.0 * n, 8.0),
        hold=np.full(n, 2.0),
        wrench=planned.wrench + sensor * rng.normal(size=(n, 6)),
        position=position[:, None],
        rotation=rotation[:, None],
    )
    return SimulatedCampaign(chain, states, 1.0 / stiffness)


def _loads(rng: np.random.Generator, plan: Plan) -> tuple[Floats, Floats]:
    """Return joints (poses, 6) and true wrenches (poses, loads, 6): cycles up and down, no level ever hit exactly."""
    per_run = 1 + plan.directions * plan.cycles * len(LEVELS)
    joints = six_axis_joints(rng, plan.poses)
    wrench = np.empty((plan.poses, per_run, 6))
    scale = np.repeat([plan.force, plan.moment], 3) / np.sqrt(3.0)
    for pose in range(plan.poses):
        peaks = rng.normal(size=(plan.directions, 6)) * scale
        levels = np.tile(LEVELS, plan.cycles)
        aimed = (peaks[:, None] * levels[None, :, None]).reshape(-1, 6)
        wrench[pose, 0] = 0.0
        wrench[pose, 1:] = aimed * (1.0 + 0.03 * rng.normal(size=(len(aimed), 1)))
        # the rope never pulls quite straight, and never hangs quite slack
        size = np.linalg.norm(aimed[:, :3], axis=1, keepdims=True)
        wrench[pose, 1:, :3] += 0.02 * size * rng.normal(size=(len(aimed), 3))
        wrench[pose] += rng.normal(size=(per_run, 6)) * np.repeat([0.5, 0.1], 3)
    return joints, wrench


def turn_by(vector: Floats) -> Floats:
    """Return (n, 3, 3) rotations by (n, 3) rotation vectors, by Cayley's formula (right to the third order)."""
    half = np.zeros((len(vector), 3, 3))
    x, y, z = vector.T / 2.0
    half[:, 0, 1], half[:, 0, 2], half[:, 1, 2] = -z, y, -x
    half[:, 1, 0], half[:, 2, 0], half[:, 2, 1] = z, -y, x
    return np.asarray(np.linalg.solve(np.eye(3) - half, np.eye(3) + half), dtype=np.float64)
