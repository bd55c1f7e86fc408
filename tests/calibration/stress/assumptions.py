"""What the judge assumes of instruments, plans and masses, broken: nothing else is wrong, or one effect is hidden."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from tests.calibration.stress.drawing import Hidden, Noise, nothing_or_one
from tests.laboratory.random_robots import DrawnRobot, draw_robot
from tests.rates.measuring import Motion, Player, move
from tests.rates.playing import Ruler

DEGREES_OF_FREEDOM = 3.0
"""Of heavy-tailed noise."""
SHARED = 0.8
"""Share of the noise's variance that all axes have in common."""
CROSS_TALK = (0.01, 0.03)
"""Of the sensor's range that a component reads of each other one."""
SENSOR_ARM = 0.1
"""m, the sensor's range of moments over that of forces."""
ANGLE_STEP = np.radians(0.01)
"""rad, in which angles are logged."""
FEW_POSES = (4, 8)
CLUSTER = 0.1
"""Spread of clustered poses over the usual one."""
WRONG_ROTATION = (0.5, 2.0)
"""Stated noise of rotations over the true one."""
TOOL_SHARE = (0.05, 0.5)
"""Weight of a tool or a payload over the largest load."""
GRAVITY = 9.80665


class HeavyTails(np.random.Generator):
    """Draws t noise of three degrees of freedom, of unit standard deviation, where Gaussian noise is asked for."""

    def normal(self, loc: Any = 0.0, scale: Any = 1.0, size: Any = None) -> Any:
        """Return as `numpy.random.Generator.normal`."""
        drawn = self.standard_t(DEGREES_OF_FREEDOM, size) * np.sqrt(1.0 - 2.0 / DEGREES_OF_FREEDOM)
        return loc + scale * drawn


class CommonNoise(np.random.Generator):
    """Draws noise of which the axes of a reading have a part in common."""

    def normal(self, loc: Any = 0.0, scale: Any = 1.0, size: Any = None) -> Any:
        """Return as `numpy.random.Generator.normal`; the last axis of the array is that of the components."""
        own = super().normal(size=size)
        common = super().normal(size=(*np.shape(own)[:-1], 1))
        return loc + scale * (np.sqrt(SHARED) * common + np.sqrt(1.0 - SHARED) * own)


def heavy_tails(rng: np.random.Generator) -> np.random.Generator:
    """Return a generator of heavy-tailed noise on the same stream."""
    return HeavyTails(rng.bit_generator)


def common_noise(rng: np.random.Generator) -> np.random.Generator:
    """Return a generator of noise common to the axes on the same stream."""
    return CommonNoise(rng.bit_generator)


def cross_talk(rng: np.random.Generator, plan: LoadStates) -> LoadStates:
    """Return the loads as a sensor reads them whose components read a part of each other."""
    part = rng.uniform(*CROSS_TALK, (6, 6)) * rng.choice([-1.0, 1.0], (6, 6))
    np.fill_diagonal(part, 0.0)
    unit = np.repeat([1.0, SENSOR_ARM], 3)
    read = plan.wrench + plan.wrench @ (unit[:, None] * part / unit[None, :]).T
    if not plan.setup.moments_measured:
        read[:, 3:] = 0.0
    return replace(plan, wrench=read)


def hide_no_torque_law(rng: np.random.Generator, ruler: Ruler) -> Hidden:
    """Hide nothing, or one effect that needs no knowledge of the weights."""
    return nothing_or_one(rng, ruler, of_total_torque=False)


def gravity_downwards(model: CompliantRobot) -> CompliantRobot:
    """Return the model of a robot as if it stood on the floor."""
    return replace(model, chain=replace(model.chain, gravity=np.array([0.0, 0.0, -GRAVITY])))


def unchanged(model: CompliantRobot) -> CompliantRobot:
    """Return the model with its masses known."""
    return model


def _with_tool(plan: LoadStates, mass: float) -> LoadStates:
    return replace(plan, setup=replace(plan.setup, tool_mass=mass, tool_com=np.array([0.02, 0.0, 0.1])))


def _draw_mass(rng: np.random.Generator, plan: LoadStates) -> float:
    force = float(np.linalg.norm(plan.wrench[:, :3], axis=1).max())
    return float(rng.uniform(*TOOL_SHARE)) * force / GRAVITY


def tool_not_stated(
    rng: np.random.Generator, player: Player, plan: LoadStates, springs: CompliantRobot, whole: CompliantRobot
) -> Motion:
    """Return the motion of the robot with a tool of which the manifest says nothing."""
    return move(player, _with_tool(plan, _draw_mass(rng, plan)), springs, whole)


def payload_changed(
    rng: np.random.Generator, player: Player, plan: LoadStates, springs: CompliantRobot, whole: CompliantRobot
) -> Motion:
    """Return the motion of the robot with a payload that it carries from one of its runs on; the sensor is zeroed."""
    numbers = np.unique(plan.run)
    later = plan.run >= rng.choice(numbers[1:])
    mass = _draw_mass(rng, plan)
    parts = []
    for own, kilograms in ((~later, 0.0), (later, mass)):
        part = plan.select(own)
        _, run = np.unique(part.run, return_inverse=True)
        part = replace(part, run=run, runs=tuple(plan.runs[k] for k in np.unique(plan.run[own])))
        parts.append(move(player, _with_tool(part, kilograms), springs, whole))
    before, after = parts

    def joined(name: str) -> Floats:
        return np.concatenate([getattr(before, name), getattr(after, name)])

    return Motion(joined("position"), joined("rotation"), joined("moved"))


def quantised_angles(rng: np.random.Generator, states: LoadStates, noise: Noise) -> LoadStates:
    """Return the angles as a log with two decimals of a degree holds them."""
    return replace(states, joints=ANGLE_STEP * np.round(states.joints / ANGLE_STEP))


def rotation_stated_wrong(rng: np.random.Generator, states: LoadStates, noise: Noise) -> LoadStates:
    """Return the states with the noise of translations stated as it is, that of rotations not."""
    times = float(rng.choice(WRONG_ROTATION))
    sigma = replace(states.setup.sigma, translation=noise[0], rotation=times * noise[1])
    return replace(states, setup=replace(states.setup, sigma=sigma))


def one_direction(rng: np.random.Generator, plan: LoadStates) -> LoadStates:
    """Return the plan with all loads along one direction of the sensor's, pushed and pulled as before."""
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    sign = np.where(plan.wrench[:, :3] @ way < 0.0, -1.0, 1.0)
    size = sign * np.linalg.norm(plan.wrench[:, :3], axis=1)
    wrench = plan.wrench.copy()
    wrench[:, :3] = size[:, None] * way
    if plan.setup.moments_measured:
        wrench[:, 3:] = np.cross([0.02, 0.0, 0.13], wrench[:, :3])
    return replace(plan, wrench=wrench)


def few_poses(rng: np.random.Generator, plan: LoadStates) -> LoadStates:
    """Return the first four to eight poses of the plan."""
    poses = int(rng.integers(FEW_POSES[0], FEW_POSES[1] + 1))
    return replace(plan.select(plan.run < poses), runs=plan.runs[:poses])


def clustered(rng: np.random.Generator) -> DrawnRobot:
    """Return a robot that is measured near one pose."""
    robot = draw_robot(rng)
    family = robot.family
    centre = np.array(family.centre) + 0.5 * np.array(family.spread) * rng.uniform(-1.0, 1.0, len(family.centre))
    spread = tuple(CLUSTER * value for value in family.spread)
    return replace(robot, family=replace(family, centre=tuple(centre), spread=spread))
