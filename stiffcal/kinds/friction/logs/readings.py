"""What friction runs measure: a drive's torque at steady velocities, or while a motion goes on that is not steady."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.columns import TABLE_DOCUMENT
from stiffcal.measurements.load_states import RunInfo
from stiffcal.measurements.set_aside import SetAsideCode

STEADY = "stiffcal/friction/1"
MOTION = "stiffcal/free-motion/1"


@dataclass(frozen=True)
class SteadyReadings:
    """m passes of one joint at constant velocity in free motion; values at the joint's side of the gear."""

    runs: tuple[RunInfo, ...]
    """R runs."""
    run: Integers
    """(m,) index into ``runs``."""
    joint: Integers
    """(m,) the joint that moved, from 1."""
    velocity: Floats
    """(m,) rad/s, as logged, mean over the stretch; its sign is the direction of motion."""
    torque: Floats
    """(m,) N·m, the drive's, mean over the stretch."""
    stretch: Integers
    """(m,) number of the stretch of angle: passes of one joint that share it, at one speed and with the other joints
    alike, carry the same mean weight.
    """
    low: Floats
    """(m,) rad, where that stretch begins."""
    high: Floats
    """(m,) rad, where it ends."""
    start: Floats
    """(m,) s on the log's clock, where the velocity began to be constant."""
    end: Floats
    """(m,) s on the log's clock, where it ceased to be."""
    n_readings: Integers
    """(m,) samples averaged."""
    scatter: Floats
    """(m,) N·m, standard deviation of single samples about the mean."""
    set_aside: NDArray[np.str_]
    """(m,) text for people why the pass is not used, "" where it is."""
    set_aside_code: NDArray[np.str_]
    """(m,) values of `SetAsideCode`."""

    def __len__(self) -> int:
        return int(self.run.shape[0])

    @property
    def used(self) -> Booleans:
        """(m,) True for the passes that are not set aside."""
        return np.asarray(self.set_aside_code == SetAsideCode.NONE.value, dtype=np.bool_)

    def select(self, keep: Booleans | Integers) -> SteadyReadings:
        """Return the passes picked by a mask or by indices; runs keep their numbers."""
        names = [name for name in self.__dataclass_fields__ if name != "runs"]
        return replace(self, **{name: getattr(self, name)[keep] for name in names})


@dataclass(frozen=True)
class FreeMotion:
    """n samples of a motion in the air that is not steady, evenly spaced pieces of one or more runs.

    Weight and inertia are in the torque; the rigid-body model takes them out.
    """

    runs: tuple[RunInfo, ...]
    """R runs."""
    run: Integers
    """(n,) index into ``runs``."""
    time: Floats
    """(n,) s on the log's clock."""
    angles: Floats
    """(n, J) rad, of the chain's model joints."""
    velocity: Floats
    """(n, J) rad/s, of the chain's model joints."""
    acceleration: Floats
    """(n, J) rad/s², of the chain's model joints."""
    drive_velocity: Floats
    """(n, J) rad/s, of the drives at the joint's side of the gear."""
    drive_acceleration: Floats
    """(n, J) rad/s², of the drives at the joint's side of the gear."""
    torque: Floats
    """(n, J) N·m of the drives, at the joint's side."""
    one_way: Booleans
    """(n, J) True where the drive kept its direction for as long as one sample takes in: there the sign of its velocity
    is one number.
    """

    def __len__(self) -> int:
        return int(self.run.shape[0])

    def select(self, keep: Booleans | Integers) -> FreeMotion:
        """Return the samples picked by a mask or by indices; runs keep their numbers."""
        names = [name for name in self.__dataclass_fields__ if name != "runs"]
        return replace(self, **{name: getattr(self, name)[keep] for name in names})


def stacked_motion(parts: Sequence[FreeMotion]) -> FreeMotion:
    """Return the samples of several runs one after the other."""
    start = np.cumsum([0, *(len(motion.runs) for motion in parts)])
    arrays = {
        name: np.concatenate([getattr(motion, name) for motion in parts])
        for name in FreeMotion.__dataclass_fields__
        if name not in ("runs", "run")
    }
    run = np.concatenate([motion.run + first for motion, first in zip(parts, start, strict=False)])
    return FreeMotion(runs=tuple(run for motion in parts for run in motion.runs), run=run, **arrays)


def steady_table(readings: SteadyReadings, joint_names: tuple[str, ...]) -> pa.Table:
    """Return the passes as a table, one row each, a unit in every column's name."""
    columns = {
        "run": pa.array([readings.runs[k].name for k in readings.run], pa.string()),
        "joint": pa.array([joint_names[k - 1] for k in readings.joint], pa.string()),
        "velocity_radps": readings.velocity,
        "torque_Nm": readings.torque,
        "stretch": readings.stretch,
        "low_rad": readings.low,
        "high_rad": readings.high,
        "start_s": readings.start,
        "end_s": readings.end,
        "n_readings": readings.n_readings,
        "torque_scatter_Nm": readings.scatter,
        "set_aside": pa.array(readings.set_aside.tolist(), pa.string()),
        "set_aside_code": pa.array(readings.set_aside_code.tolist(), pa.string()),
    }
    return with_runs(pa.table(columns), readings.runs, joint_names, STEADY)


def steady_from_table(table: pa.Table) -> SteadyReadings:
    """Return the passes of a table that `steady_table` made; ValueError where it is of another kind."""
    runs, joints = runs_of(table, STEADY)
    column = partial(column_of, table)
    number = {run.name: k for k, run in enumerate(runs)}
    return SteadyReadings(
        runs=runs,
        run=np.array([number[name] for name in table.column("run").to_pylist()], dtype=np.int64),
        joint=np.array([joints.index(name) + 1 for name in table.column("joint").to_pylist()], dtype=np.int64),
        velocity=column("velocity_radps"),
        torque=column("torque_Nm"),
        stretch=column("stretch").astype(np.int64),
        low=column("low_rad"),
        high=column("high_rad"),
        start=column("start_s"),
        end=column("end_s"),
        n_readings=column("n_readings").astype(np.int64),
        scatter=column("torque_scatter_Nm"),
        set_aside=np.array(table.column("set_aside").to_pylist(), dtype=np.str_),
        set_aside_code=np.array(table.column("set_aside_code").to_pylist(), dtype=np.str_),
    )


_MOTION = {
    "angles": "model_rad",
    "velocity": "model_radps",
    "acceleration": "model_radps2",
    "drive_velocity": "drive_radps",
    "drive_acceleration": "drive_radps2",
    "torque": "drive_Nm",
}


def motion_table(motion: FreeMotion, joint_names: tuple[str, ...]) -> pa.Table:
    """Return the samples as a table: ``run``, ``time_s``, and ``<joint>_model_rad`` … ``<joint>_one_way``."""
    columns: dict[str, Any] = {
        "run": pa.array([motion.runs[k].name for k in motion.run], pa.string()),
        "time_s": motion.time,
    }
    for name, ending in _MOTION.items():
        columns |= {f"{joint}_{ending}": getattr(motion, name)[:, k] for k, joint in enumerate(joint_names)}
    columns |= {f"{joint}_one_way": motion.one_way[:, k] for k, joint in enumerate(joint_names)}
    return with_runs(pa.table(columns), motion.runs, joint_names, MOTION)


def motion_from_table(table: pa.Table) -> FreeMotion:
    """Return the samples of a table that `motion_table` made; ValueError where it is of another kind."""
    runs, joints = runs_of(table, MOTION)
    number = {run.name: k for k, run in enumerate(runs)}

    def block(ending: str) -> Floats:
        return np.stack([column_of(table, f"{joint}_{ending}") for joint in joints], axis=1)

    return FreeMotion(
        runs=runs,
        run=np.array([number[name] for name in table.column("run").to_pylist()], dtype=np.int64),
        time=column_of(table, "time_s"),
        **{name: block(ending) for name, ending in _MOTION.items()},
        one_way=block("one_way").astype(np.bool_),
    )


def column_of(table: pa.Table, name: str) -> Floats:
    """Return a column of numbers."""
    return np.asarray(table.column(name).to_numpy(), dtype=np.float64)


def with_runs(
    table: pa.Table, runs: Sequence[RunInfo], joint_names: tuple[str, ...], schema: str, **more: object
) -> pa.Table:
    """Return a table that names its schema, its runs and joints, and ``more``, in its metadata."""
    document = {
        **more,
        "schema": schema,
        "joints": list(joint_names),
        "runs": [
            {"name": run.name, "experiment": run.experiment, "holdout": run.holdout, "tags": list(run.tags)}
            for run in runs
        ],
    }
    return table.replace_schema_metadata({TABLE_DOCUMENT: json.dumps(document)})


def runs_of(table: pa.Table, schema: str) -> tuple[tuple[RunInfo, ...], list[str]]:
    """Return the runs and joints of a table; ValueError where it is of another schema."""
    document = json.loads((table.schema.metadata or {}).get(TABLE_DOCUMENT, b"{}"))
    if document.get("schema") != schema:
        raise ValueError(f"this table is not {schema}; ingest again")
    runs = [RunInfo(run["name"], run["experiment"], run["holdout"], tuple(run["tags"])) for run in document["runs"]]
    return tuple(runs), list(document["joints"])
