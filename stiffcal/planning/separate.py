"""Which pose and load would distinguish two models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import NoBalanceError, solve_balance
from stiffcal.planning.rivals import RivalModel, pairs_of_rivals, separating_design

# Poses drawn; the best of 400 lies within a few per cent of the best there is in six dimensions of smooth functions.
POSES = 400


# Of the drawn poses with loads, those that differ most are compared with the models refitted.
REFITTED = 200


@dataclass(frozen=True)
class KnownPair:
    """What the campaign fixes of two models."""

    first: RivalModel
    """With the information that the campaign's data hold on its parameters."""
    second: RivalModel
    """Likewise."""
    noise: Noise
    """Of one load state."""
    with_rotation: bool
    """Orientations are measured too."""
    fixed: frozenset[str]
    """Full names of parameters that are not fitted."""


@dataclass(frozen=True)
class ChosenMeasurement:
    """A measurement that two models disagree on most."""

    joints: Floats
    """(L,) logged joint angles, rad."""
    wrench: Floats
    """(6,) in the sensor's axes, N and N·m."""
    difference: float
    """Of the two predictions, m."""
    gain: float
    """Difference over the noise of one reading; with all that is known, what a refit leaves of it over the noise."""


def separating_measurement(
    first: CompliantRobot,
    second: CompliantRobot,
    setup: MeasurementSetup,
    measured_joints: Floats,
    wrench: Floats,
    noise: float,
    seed: int = 0,
    known: KnownPair | None = None,
) -> ChosenMeasurement | None:
    """Return the pose and load that separate two models most.

    Without ``known`` that is where their displacements differ most; with it, where the difference is largest that a
    refit of either model to all data cannot take up (`rivals`: the same design as of `plan`, of one run).

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
    known : what the campaign fixes of both models' parameters already.
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
    if known is None:
        best = int(np.argmax(difference))
        size = float(difference[best])
        return ChosenMeasurement(poses[best], forces[best], size, size / noise if noise > 0.0 else np.inf)
    tried = np.argsort(difference, kind="stable")[-REFITTED:]
    rivals = (known.first, known.second)
    pairs = pairs_of_rivals(
        rivals, poses[tried], forces[tried][:, None], setup, known.noise, known.with_rotation, known.fixed
    )
    chosen = separating_design(pairs, 1).chosen
    best = int(tried[chosen[0]])
    gain = float(np.sqrt(min(pair.separation(chosen) for pair in pairs)))
    return ChosenMeasurement(poses[best], forces[best], float(difference[best]), gain)


def _largest_loads(wrench: Floats) -> Floats:
    """Return (6, 6): the campaign's largest force along and against each axis, with the moment that came with it."""
    picked = [int(np.argmax(sign * wrench[:, axis])) for axis in range(3) for sign in (1.0, -1.0)]
    return wrench[picked]
