"""To and fro at constant velocity: angles of trapezoidal strokes, and runs of one joint made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.effects.joint_friction import JointFriction
from stiffcal.kinds.friction.logs.friction_run import FrictionRun
from stiffcal.measurements.load_states import RunInfo
from stiffcal.mechanics.chain import Chain
from tests.laboratory.friction_law import friction_torque
from tests.laboratory.robots import six_axes

INTERVAL = 0.005
SLOW_AND_FAST = (0.02, 0.04, 0.06, 0.08, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0)
LAW = JointFriction()


def stroke(time: Floats, speed: float, length: float, acceleration: float) -> Floats:
    """Return (n,) how far a trapezoidal stroke has come, rad; triangular where the length is too short."""
    speed = min(speed, float(np.sqrt(length * acceleration)))
    ramp = speed / acceleration
    whole = length / speed + ramp
    t = np.clip(time, 0.0, whole)
    return np.where(
        t < ramp,
        0.5 * acceleration * t**2,
        np.where(t < whole - ramp, speed * (t - 0.5 * ramp), length - 0.5 * acceleration * (whole - t) ** 2),
    )


def to_and_fro(
    speed: float, low: float = -0.5, high: float = 0.8, cycles: int = 3, acceleration: float = 8.0, rest: float = 0.3
) -> tuple[Floats, Floats]:
    """Return time (n,) and angle (n,) of strokes up and down with rests between."""
    length = high - low
    reached = min(speed, float(np.sqrt(length * acceleration)))
    one = length / reached + reached / acceleration + rest
    time = np.arange(0.0, 2 * cycles * one + rest, INTERVAL)
    angle = np.full(time.size, low)
    for k in range(cycles):
        begins = rest + 2 * k * one
        angle += stroke(time - begins, speed, length, acceleration)
        angle -= stroke(time - begins - one, speed, length, acceleration)
    return time, angle


def friction_runs(
    values: Mapping[str, float],
    speeds: Sequence[float] = SLOW_AND_FAST,
    noise: float = 5.0,
    joint: int = 2,
    weight: float = 120.0,
    seed: int = 7,
    ripple_order: float = 0.0,
) -> list[FrictionRun]:
    """Return one run per speed: friction, weight that follows the angle, inertia, gear ripple, noise.

    With ``ripple_order`` waves of 8 N·m in addition.
    """
    rng = np.random.default_rng(seed)
    runs = []
    for speed in speeds:
        time, angle = to_and_fro(speed)
        velocity = np.gradient(angle, INTERVAL)
        torque = friction_torque(velocity, values) + weight * np.cos(angle) + 15.0 * np.gradient(velocity, INTERVAL)
        torque += 8.0 * np.sin(ripple_order * angle)
        torque += 3.0 * np.sin(80.0 * angle) + noise * rng.normal(size=time.size)
        runs.append(run_of(f"{speed:g}", joint, time, angle, torque))
    return runs


def run_of(name: str, joint: int, time: Floats, angle: Floats, torque: Floats) -> FrictionRun:
    """Return a run in which one of six joints moves."""
    angles, torques = np.zeros((time.size, 6)), np.zeros((time.size, 6))
    angles[:, joint - 1], torques[:, joint - 1] = angle, torque
    return FrictionRun(RunInfo(name, "friction"), None, time, angles, torques, None)


def robot() -> Chain:
    """Return the medium six-axis robot."""
    return six_axes()
