"""What clamped runs measure: motor angles driven to and fro, the wrench at the fixture, the motors' torques (004)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.columns import TABLE_DOCUMENT
from stiffcal.measurements.load_states import RunInfo

SCHEMA = "stiffcal/clamped-readings/1"
_WRENCH = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")


CLAMPED = "clamped"


@dataclass(frozen=True)
class ClampedReadings:
    """n readings of clamped runs, in order of time within each run, all on the clock of the joints' log."""

    runs: tuple[RunInfo, ...]
    """R runs."""
    run: Integers
    """(n,) index into ``runs``."""
    time: Floats
    """(n,) s on the clock of the log that holds the motor angles."""
    joints: Floats
    """(n, L) motor angles at the joint's side of the gear, rad, as the controller counts them."""
    wrench: Floats
    """(n, 6) N, N·m, what the fixture does to the robot, sensor axes; NaN where no force sensor was read."""
    torque: Floats
    """(n, L) N·m, the motors' torques at the joint's side, friction included; NaN where not logged."""
    two_clocks: Booleans
    """(R,) True where angles and wrench come from devices with clocks of their own."""

    def __len__(self) -> int:
        return int(self.run.shape[0])

    def of_run(self, number: int) -> ClampedReadings:
        """Return the readings of one run; runs keep their numbers."""
        keep = self.run == number
        names = ("run", "time", "joints", "wrench", "torque")
        return replace(self, **{name: getattr(self, name)[keep] for name in names})


def stacked_readings(parts: list[ClampedReadings]) -> ClampedReadings:
    """Return the readings of several runs as one, in order."""
    start = np.cumsum([0, *(len(readings.runs) for readings in parts)])
    return ClampedReadings(
        runs=tuple(run for readings in parts for run in readings.runs),
        run=np.concatenate([readings.run + first for readings, first in zip(parts, start, strict=False)]),
        time=np.concatenate([readings.time for readings in parts]),
        joints=np.concatenate([readings.joints for readings in parts]),
        wrench=np.concatenate([readings.wrench for readings in parts]),
        torque=np.concatenate([readings.torque for readings in parts]),
        two_clocks=np.concatenate([readings.two_clocks for readings in parts]),
    )


def readings_table(
    readings: ClampedReadings, joint_names: tuple[str, ...], described: Mapping[str, object] | None = None
) -> pa.Table:
    """Return the readings as a table: ``run``, ``time_s``, ``<joint>_rad``, ``Fx_N … Mz_Nm``, ``<joint>_Nm``.

    Parameters
    ----------
    described : what else decides what is made of them (frames, moved joints, fixtures), kept with them.
    """
    columns = {"run": pa.array([readings.runs[k].name for k in readings.run], pa.string()), "time_s": readings.time}
    columns |= {f"{name}_rad": readings.joints[:, k] for k, name in enumerate(joint_names)}
    columns |= {name: readings.wrench[:, k] for k, name in enumerate(_WRENCH)}
    columns |= {f"{name}_Nm": readings.torque[:, k] for k, name in enumerate(joint_names)}
    document = {
        "schema": SCHEMA,
        "joints": list(joint_names),
        "described": dict(described or {}),
        "runs": [
            {
                "name": run.name, "experiment": run.experiment, "holdout": run.holdout, "tags": list(run.tags),
                "two_clocks": bool(apart),
            }
            for run, apart in zip(readings.runs, readings.two_clocks, strict=True)
        ],
    }  # fmt: skip
    return pa.table(columns).replace_schema_metadata({TABLE_DOCUMENT: json.dumps(document)})


def readings_from_table(table: pa.Table) -> ClampedReadings:
    """Return the readings of a table that `readings_table` made.

    Raises
    ------
    ValueError
        The table is of another kind or version.
    """
    document = json.loads((table.schema.metadata or {}).get(TABLE_DOCUMENT, b"{}"))
    if document.get("schema") != SCHEMA:
        raise ValueError(f"this table is not {SCHEMA}; ingest again")
    runs = tuple(
        RunInfo(run["name"], run["experiment"], run["holdout"], tuple(run["tags"])) for run in document["runs"]
    )
    number = {run.name: k for k, run in enumerate(runs)}

    def block(names: list[str]) -> Floats:
        return np.stack([table.column(name).to_numpy() for name in names], axis=1).astype(np.float64)

    joints = document["joints"]
    return ClampedReadings(
        runs=runs,
        run=np.array([number[name] for name in table.column("run").to_pylist()], dtype=np.int64),
        time=table.column("time_s").to_numpy().astype(np.float64),
        joints=block([f"{name}_rad" for name in joints]),
        wrench=block(list(_WRENCH)),
        torque=block([f"{name}_Nm" for name in joints]),
        two_clocks=np.array([run["two_clocks"] for run in document["runs"]], dtype=np.bool_),
    )
