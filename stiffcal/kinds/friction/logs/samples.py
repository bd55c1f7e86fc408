"""Samples within passes at constant velocity: what the rows of equations are averaged from.

A pass of any length is kept as at most `MOST_PER_PASS` means of neighbouring samples, so that the store stays small.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.kinds.friction.logs.readings import SteadyReadings, column_of, runs_of, with_runs
from stiffcal.kinds.friction.logs.steady import JointPass
from stiffcal.measurements.columns import TABLE_DOCUMENT
from stiffcal.measurements.load_states import RunInfo
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.like_poses import SAME_POSE_RAD
from stiffcal.mechanics.rigid_body import drive_matrix, inertial_regressor, rigid_torque
from stiffcal.model.balance.stated_spring import spring_torque

if TYPE_CHECKING:
    from stiffcal.kinds.friction.logs.friction_run import FrictionRun

SAMPLES = "stiffcal/friction-samples/1"
# A dozen places in a pass, each of sixteen: their scatter shows the noise.
MOST_PER_PASS = 200
# m/s² or m²/s², of gravity across an axis: an axis is as plumb as a robot can be set up.
LEAST_GRAVITY = 1e-3


@dataclass(frozen=True)
class PassSamples:
    """n means of neighbouring samples within passes at constant velocity, at the joint's side of the gear."""

    runs: tuple[RunInfo, ...]
    """R runs."""
    run: Integers
    """(n,) index into ``runs``."""
    joint: Integers
    """(n,) the joint that moved, from 1."""
    reading: Integers
    """(n,) index of the pass into `SteadyReadings`."""
    stretch: Integers
    """(n,) the pass's `SteadyReadings.stretch`."""
    pose: Integers
    """(n,) number of the place where the other joints stood; the weight depends on it."""
    time: Floats
    """(n,) s on the log's clock."""
    velocity: Floats
    """(n,) rad/s, the pass's mean as logged."""
    angle: Floats
    """(n,) rad, as logged."""
    torque: Floats
    """(n,) N·m, the drive's."""
    load: Floats
    """(n,) N·m that weight puts on the drive; 0 where the masses are not known."""
    carries_weight: Booleans
    """(n,) True where gravity acts about the joint's axis."""
    temperature: Floats
    """(n,) K; NaN where not logged."""
    travel: Floats
    """(n,) rad since the direction of motion last changed; NaN where that is not logged."""
    n_readings: Integers
    """(n,) samples averaged."""
    logged_travel: Mapping[int, tuple[float, float]]
    """Joint to its smallest and largest logged angle, rad."""
    first_temperature: Mapping[int, float]
    """Joint to the first logged temperature of its runs, K; NaN where none is logged."""

    def __len__(self) -> int:
        return int(self.run.size)

    def select(self, keep: Booleans | Integers) -> PassSamples:
        """Return the samples picked by a mask or by indices; runs keep their numbers."""
        apart = ("runs", "logged_travel", "first_temperature")
        names = [name for name in self.__dataclass_fields__ if name not in apart]
        return replace(self, **{name: getattr(self, name)[keep] for name in names})


def pass_samples(
    runs: Sequence[FrictionRun], passes: Sequence[JointPass], steady: SteadyReadings, chain: Chain
) -> PassSamples | None:
    """Return the samples within the passes that are used; None where none is.

    Parameters
    ----------
    runs : the logs. passes : found in them, in the order of ``steady``. chain : the robot.
    """
    poses = _poses(passes)
    pieces: list[dict[str, np.ndarray]] = []
    for k in np.flatnonzero(steady.used).tolist():
        held, run = passes[k].steady_pass, runs[passes[k].run]
        size = -(-held.time.size // MOST_PER_PASS)
        count = held.time.size // size
        temperature = np.full(held.time.size, np.nan)
        if run.temperature is not None:
            temperature = np.interp(held.time, run.time, run.temperature)
        angle = _means(held.angle, size, count)
        logged = np.tile(passes[k].other_angles, (count, 1))
        logged[:, passes[k].joint - 1] = angle
        whole = np.ones(count, dtype=np.int64)
        pieces.append(
            {
                "run": passes[k].run * whole,
                "joint": passes[k].joint * whole,
                "reading": k * whole,
                "stretch": int(steady.stretch[k]) * whole,
                "pose": poses[k] * whole,
                "time": _means(held.time, size, count),
                "velocity": np.full(count, held.velocity),
                "angle": angle,
                "torque": _means(held.torque, size, count),
                "load": _load(chain, logged, passes[k].joint),
                "carries_weight": np.full(count, _carries_weight(chain, logged, passes[k].joint)),
                "temperature": _means(temperature, size, count),
                "travel": np.abs(angle - held.turned_at),
                "n_readings": size * whole,
            }
        )
    if not pieces:
        return None
    arrays = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    travel: dict[int, tuple[float, float]] = {}
    for joint in np.unique(arrays["joint"]).tolist():
        moved = [runs[k].angle[:, joint - 1] for k in np.unique(arrays["run"][arrays["joint"] == joint])]
        travel[joint] = (float(min(angle.min() for angle in moved)), float(max(angle.max() for angle in moved)))
    first = {joint: _first_temperature(runs, arrays["run"][arrays["joint"] == joint]) for joint in travel}
    return PassSamples(runs=steady.runs, logged_travel=travel, first_temperature=first, **arrays)


def _first_temperature(runs: Sequence[FrictionRun], chosen: Integers) -> float:
    """Return the first logged temperature of some runs, K; NaN where the first of them logged none."""
    temperature = runs[int(chosen.min())].temperature
    return float("nan") if temperature is None else float(temperature[0])


def _means(values: Floats, size: int, count: int) -> Floats:
    return np.asarray(values[: size * count].reshape(count, size).mean(axis=1))


def _poses(passes: Sequence[JointPass]) -> list[int]:
    """Number the places where the other joints stood, for each moved joint by itself."""
    kept: list[JointPass] = []
    numbers = []
    for joint_pass in passes:
        same = [
            k
            for k, other in enumerate(kept)
            if other.joint == joint_pass.joint
            and np.abs(other.other_angles - joint_pass.other_angles).max(initial=0.0) < SAME_POSE_RAD
        ]
        numbers.append(same[0] if same else len(kept))
        if not same:
            kept.append(joint_pass)
    return numbers


def _load(chain: Chain, logged: Floats, joint: int) -> Floats:
    """Return (n,) N·m that weight puts on a drive at logged angles (n, L); 0 where masses are not known."""
    if not chain.masses_known:
        return np.zeros(len(logged))
    angles = logged @ chain.coupling.T + chain.offset
    rest = np.zeros_like(angles)
    held = rigid_torque(chain, angles, rest, rest) - spring_torque(chain, angles)
    return np.asarray((held @ drive_matrix(chain))[:, joint - 1])


def _carries_weight(chain: Chain, logged: Floats, joint: int) -> bool:
    """Return whether the weight of some link could make a torque on a drive at one of some logged angles (n, L)."""
    angles = logged @ chain.coupling.T + chain.offset
    rest = np.zeros_like(angles)
    torques = np.einsum("ji,njk->nik", drive_matrix(chain), inertial_regressor(chain, angles, rest, rest))
    return bool(np.abs(torques[:, joint - 1]).max(initial=0.0) > LEAST_GRAVITY)


_UNITS = {
    "time": "time_s",
    "velocity": "velocity_radps",
    "angle": "angle_rad",
    "torque": "torque_Nm",
    "load": "load_Nm",
    "temperature": "temperature_K",
    "travel": "travel_rad",
}
_NUMBERS = ("reading", "stretch", "pose", "n_readings")


def samples_table(samples: PassSamples, joint_names: tuple[str, ...]) -> pa.Table:
    """Return the samples as a table, one row each, a unit in every column's name."""
    columns = {
        "run": pa.array([samples.runs[k].name for k in samples.run], pa.string()),
        "joint": pa.array([joint_names[k - 1] for k in samples.joint], pa.string()),
        **{name: getattr(samples, name) for name in (*_NUMBERS, "carries_weight")},
        **{name: getattr(samples, field) for field, name in _UNITS.items()},
    }
    travel = {str(joint): list(ends) for joint, ends in samples.logged_travel.items()}
    first = {str(joint): value if value == value else None for joint, value in samples.first_temperature.items()}
    return with_runs(pa.table(columns), samples.runs, joint_names, SAMPLES, logged_travel=travel, first_K=first)


def samples_from_table(table: pa.Table) -> PassSamples:
    """Return the samples of a table that `samples_table` made; ValueError where it is of another kind."""
    runs, joints = runs_of(table, SAMPLES)
    number = {run.name: k for k, run in enumerate(runs)}
    document = json.loads((table.schema.metadata or {})[TABLE_DOCUMENT])
    travel, first = document["logged_travel"], document["first_K"]
    numbers: dict[str, Any] = {name: column_of(table, name).astype(np.int64) for name in _NUMBERS}
    values: dict[str, Any] = {field: column_of(table, name) for field, name in _UNITS.items()}
    return PassSamples(
        runs=runs,
        run=np.array([number[name] for name in table.column("run").to_pylist()], dtype=np.int64),
        joint=np.array([joints.index(name) + 1 for name in table.column("joint").to_pylist()], dtype=np.int64),
        carries_weight=column_of(table, "carries_weight").astype(np.bool_),
        logged_travel={int(joint): (float(ends[0]), float(ends[1])) for joint, ends in travel.items()},
        first_temperature={int(joint): float("nan") if value is None else value for joint, value in first.items()},
        **numbers,
        **values,
    )
