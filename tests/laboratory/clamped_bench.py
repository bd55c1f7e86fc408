"""A robot on linear springs whose flange a fixture holds: a simulation of its own for tests of effects.

The closed chain is solved as one linear system about the pose, its Jacobian taken from places by central differences:
springs, fixture and the motors' motion share the mismatch, W = −(J K⁻¹ Jᵀ + C)⁻¹ J Δd.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import HELD, LoadStates, RunInfo
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, Place
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup

CYCLE = np.concatenate([np.linspace(0.0, 1.0, 9), np.linspace(0.9, -1.0, 20), np.linspace(-0.9, 0.0, 10)])


def held_jacobian(chain: Chain, pose: Floats) -> Floats:
    """Return (6, J) how the sensor's frame moves with logged joints, by central differences, base axes."""
    sensor, step = force_sensor_setup(chain).wrench_axes, 1e-5
    columns = []
    for k in range(len(pose)):
        ends = np.stack([pose, pose])
        ends[0, k] -= step
        ends[1, k] += step
        position, rotation = attached_poses(chain, chain.model_angles(ends), sensor)
        turn = rotation[1] @ rotation[0].T
        vector = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        columns.append(np.concatenate([position[1] - position[0], vector]) / (2.0 * step))
    return np.stack(columns, axis=1)


def clamped_bench(
    chain: Chain,
    poses: Floats,
    moved: Sequence[int],
    fixture: Floats,
    seed: int = 1,
    noise: float = 2e-6,
    drift: Floats | None = None,
    warming: Floats | None = None,
) -> LoadStates:
    """Return the states of clamped runs, two cycles each; every moved joint (from 1) in every pose.

    Parameters
    ----------
    fixture : (6, 6) compliance, base axes, about the sensor.
    noise : rad of each motor angle.
    drift : (J,) rad/s by which the readings of the joints' encoders wander; per kelvin where ``warming`` is given.
    warming : (s,) K over one run's states.
    """
    rng = np.random.default_rng(seed)
    setup = force_sensor_setup(chain)
    setup = replace(setup, targets=(*setup.targets, setup.wrench_point), target_names=(*setup.target_names, HELD))
    level = np.concatenate([CYCLE, CYCLE[1:]])
    seconds = 3.0 * np.arange(level.size)
    joints: list[Floats] = []
    wrenches: list[Floats] = []
    stamps: list[Floats] = []
    temperatures: list[Floats] = []
    run: list[int] = []
    for pose in poses:
        jacobian = held_jacobian(chain, pose)
        axes = attached_poses(chain, chain.model_angles(pose[None]), setup.wrench_axes)[1][0]
        for joint in moved:
            give = jacobian @ np.diag(1.0 / SIX_STIFFNESS[: len(pose)]) @ jacobian.T + fixture
            per_radian = -np.linalg.solve(give, jacobian[:, joint - 1])
            # Up to 400 N, 300 N·m or 2 mrad, whichever comes first.
            size = min(2e-3, 400.0 / np.linalg.norm(per_radian[:3]), 300.0 / np.linalg.norm(per_radian[3:]))
            turned = np.zeros((level.size, len(pose)))
            turned[:, joint - 1] = size * level
            wrench = np.outer(size * level, per_radian)
            wander = seconds if warming is None else warming
            reading = pose + turned + noise * rng.standard_normal(turned.shape)
            joints.append(reading + np.outer(wander, np.zeros(len(pose)) if drift is None else drift))
            wrenches.append(np.concatenate([wrench[:, :3] @ axes, wrench[:, 3:] @ axes], axis=1))
            stamps.append(np.asarray(seconds + 1000.0 * len(stamps), dtype=np.float64))
            temperatures.append(np.zeros(level.size) if warming is None else warming)
            run += [len(stamps) - 1] * level.size
    n = len(run)
    states = bare_states(
        run, np.concatenate(joints), setup, wrench=np.concatenate(wrenches), time=np.concatenate(stamps),
        position=np.full((n, 2, 3), np.nan), rotation=np.full((n, 2, 3, 3), np.nan),
        deflection=np.full((n, 2, 6), np.nan), position_scatter=np.full((n, 2, 3), np.nan),
        temperature=np.concatenate(temperatures)[:, None] if warming is not None else np.zeros((n, 0)),
    )  # fmt: skip
    return replace(
        states, runs=tuple(RunInfo(info.name, "clamped", measures=StateMeasure.MOTOR_ANGLE) for info in states.runs)
    )


def model_with(chain: Chain, effect: Effect, place: Place, drive: Effect) -> CompliantRobot:
    """Return a model of compliant drives and an effect, none of them valued; of first order, as the bench is."""
    drives = tuple(PlacedEffect(drive, Place("joints", (k,))) for k in range(1, 7))
    return CompliantRobot(chain, (*drives, PlacedEffect(effect, place)), deformed=False)
