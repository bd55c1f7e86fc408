"""What the instruments read of a campaign: a robot is moved by its loads, tracker and sensor add their noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from tests.laboratory.random_robots import DrawnRobot
from tests.rates.hiding import shift_of_places

Player = Literal["balance", "mujoco", "laws"]
"""What moves the robot: the product's own balance, or MuJoCo with none of its mechanics."""


@dataclass(frozen=True)
class Motion:
    """How a robot moves in n states.

    Attributes
    ----------
    position, rotation : (n, 3) m and (n, 3, 3) base_from_target, unloaded.
    moved : (n, 3 or 6) since then, base axes, m and rad.
    """

    position: Floats
    rotation: Floats
    moved: Floats


def measure(
    rng: np.random.Generator, plan: LoadStates, motion: Motion, robot: DrawnRobot, noise: tuple[float, float]
) -> LoadStates:
    """Return what the instruments read: the displacements, from where the robot rests, with noise."""
    n, poses = len(plan), len(plan.runs)
    off, turn = rng.normal(size=(poses, 3)) * 3e-4, rng.normal(size=(poses, 3)) * 2e-4
    position = motion.position + off[plan.run] + motion.moved[:, :3] + noise[0] * rng.normal(size=(n, 3))
    rotation = np.full((n, 1, 3, 3), np.nan)
    if plan.has_orientation:
        start = rotation_from_vector(turn[plan.run]) @ motion.rotation
        turned = rotation_from_vector(motion.moved[:, 3:]) @ start
        rotation = (rotation_from_vector(noise[1] * rng.normal(size=(n, 3))) @ turned)[:, None]
    force = 1.5e-3 * robot.family.force
    sensor = np.repeat([force, 0.15 * force * plan.setup.moments_measured], 3) * rng.normal(size=(n, 6))
    return replace(plan, wrench=plan.wrench + sensor, position=position[:, None], rotation=rotation)


def move(player: Player, plan: LoadStates, springs: CompliantRobot, whole: CompliantRobot) -> Motion:
    """Return how a robot moves under the loads of a plan.

    Parameters
    ----------
    springs : with its joint springs alone. whole : with all that is hidden.

    Raises
    ------
    NoBalanceError : the robot comes to no rest.
    """
    if player == "mujoco":
        from tests.rates.mujoco_player import move_by_mujoco

        return move_by_mujoco(plan, whole)
    return _move_by_balance(plan, springs, whole)


def _move_by_balance(plan: LoadStates, springs: CompliantRobot, whole: CompliantRobot) -> Motion:
    chain = whole.chain
    moved = predict_observations(whole, observe(plan, chain)).T
    # What motors do since the reference stands in `moved`.
    nominal = chain.model_angles(plan.joints[np.searchsorted(plan.run, plan.run)])
    rest = solve_balance(springs, nominal, np.zeros((len(plan), 6)), plan.setup)
    _, flange = attached_poses(chain, nominal, replace(plan.setup.targets[0], transform=np.eye(4)))
    still = rest.target_position[:, 0]
    return Motion(still + shift_of_places(whole.placed, still, flange), rest.target_rotation[:, 0], moved)


def bumped(rng: np.random.Generator, states: LoadStates) -> tuple[LoadStates, tuple[int, ...]]:
    """Return the states with some readings knocked away by some tenths of a millimetre."""
    count = int(rng.integers(3, 8))
    picked = rng.choice(np.flatnonzero(~states.reference), size=count, replace=False)
    position, rotation = states.position.copy(), states.rotation.copy()
    direction = rng.normal(size=(count, 3))
    size = rng.uniform(2e-4, 1e-3, size=(count, 1))
    position[picked, 0] += size * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    if states.has_orientation:
        rotation[picked, 0] = rotation_from_vector(3e-4 * rng.normal(size=(count, 3))) @ rotation[picked, 0]
    return replace(states, position=position, rotation=rotation), tuple(int(k) for k in np.sort(picked))
