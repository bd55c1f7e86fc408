"""Which pose and load would distinguish two models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.equilibrium import NoBalanceError, solve_balance

# Poses drawn; the best of 400 lies within a few per cent of the best there is in six dimensions of smooth functions.
POSES = 400


@dataclass(frozen=True)
class Separation:
    """A measurement that two models disagree on most."""

    joints: Floats
    """(L,) logged joint angles, rad."""
    wrench: Floats
    """(6,) in the sensor's axes, N and N·m."""
    difference: float
    """Of the two predictions, m."""
    gain: float
    """Difference over the noise of one reading."""


def separating_measurement(
    first: CompliantRobot,
    second: CompliantRobot,
    setup: MeasurementSetup,
    measured_joints: Floats,
    wrench: Floats,
    noise: float,
    seed: int = 0,
) -> Separation | None:
    """Return the pose and load at which two models' displacements differ most.

    Poses are drawn within the joint limits (a third beyond the measured span where none are given); loads are the
    campaign's largest, along and against each axis of the sensor.

    Parameters
    ----------
    first, second : models with values, of one chain.
    setup : where the instruments sit.
    measured_joints : (n, L) logged angles of the campaign, rad.
    wrench : (n, 6) the campaign's wrenches.
    noise : standard uncertainty of a reading, m.
    seed : of the drawing.
    """
    chain = first.chain
    rng = np.random.default_rng(seed)
    low, high = measured_joints.min(axis=0), measured_joints.max(axis=0)
    wider = np.maximum((high - low) / 3.0, np.radians(10.0))
    low = np.where(np.isfinite(chain.limits[:, 0]), chain.limits[:, 0], low - wider)
    high = np.where(np.isfinite(chain.limits[:, 1]), chain.limits[:, 1], high + wider)
    joints = low + (high - low) * rng.random((POSES, measured_joints.shape[1]))
    loads = _largest_loads(wrench)
    poses, forces = np.repeat(joints, len(loads), axis=0), np.tile(loads, (POSES, 1))
    try:
        displacements = [
            solve_balance(robot, chain.model_angles(poses), forces, setup).displacement for robot in (first, second)
        ]
    except NoBalanceError:
        return None
    # What differs in proportion to nothing — an offset — does not show: both count from the unloaded state.
    difference = np.sqrt(np.sum((displacements[0] - displacements[1])[:, 0, :3] ** 2, axis=1))
    best = int(np.argmax(difference))
    size = float(difference[best])
    return Separation(poses[best], forces[best], size, size / noise if noise > 0.0 else np.inf)


def _largest_loads(wrench: Floats) -> Floats:
    """Return (6, 6): the campaign's largest force along and against each axis, with the moment that came with it."""
    picked = [int(np.argmax(sign * wrench[:, axis])) for axis in range(3) for sign in (1.0, -1.0)]
    return wrench[picked]
