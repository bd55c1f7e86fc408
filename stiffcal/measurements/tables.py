"""Load states as a table: one row per state, a unit in every column's name, the setup as JSON in its metadata.

The table is what lies in the store, so its columns are part of the interface: a person reads it with one line of
pandas, polars or DuckDB. Rotations are unit quaternions w, x, y, z. Missing numbers are NaN.
"""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.documents import Document
from stiffcal.measurements.columns import TABLE_DOCUMENT, Values, table_of, values_of
from stiffcal.measurements.load_states import (
    Attachment,
    Gauge,
    LoadStates,
    MeasurementSetup,
    RunInfo,
    Sigma,
    TrackerPlace,
)
from stiffcal.measurements.markers import Markers
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.quaternions import quaternion_from_rotation, rotation_from_quaternion

SCHEMA = "stiffcal/states/2"
_WRENCH = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")


def states_table(states: LoadStates, joint_names: tuple[str, ...] = (), prismatic: Collection[str] = ()) -> pa.Table:
    """Return the states as a table.

    Columns: ``run`` (id), ``row`` (data row of the source, or the hold's number in the run, from 1), ``time_s``,
    ``hold_s``, ``<joint>_rad`` (``<joint>_m`` of prismatic joints),
    ``<joint>_torque_Nm`` (of the motors at rest, where they count),
    ``<joint>_approach`` (direction of each drive's last motion, where it is known of rows of absolute runs),
    ``Fx_N … Mz_Nm`` (what the surroundings do to the robot, in the axes of
    ``setup.wrench_axes``), per target ``<target>_x_m …`` and ``<target>_qw … _qz`` (base axes), ``<target>_dx_m …``
    and ``<target>_rx_rad …`` (deflection already taken), ``<target>_x_sigma_m …`` and ``<target>_rx_sigma_rad …``
    (standard uncertainty, where the log states it row by row), ``<target>_markers`` (names of the points that were
    measured, where its pose comes from points), ``<rod>_length_m`` and ``<gauge>_displacement_m`` as read,
    ``reference``, ``temperature<k>``, ``n_readings``,
    ``Fx_scatter_N …`` and ``<target>_x_scatter_m …`` (standard deviation of single readings within the hold), and
    ``motor_angle_sigma_rad`` and ``Fx_sigma_N …`` (standard uncertainty of states of clamped runs), and
    ``set_aside`` (why a state is not used, "" where it is), ``set_aside_code`` (the same as a value of `SetAsideCode`).

    Parameters
    ----------
    joint_names : L names; ``joint1`` … where none are given. prismatic : those of prismatic joints.
    """
    n_joints = states.joints.shape[1]
    names = joint_names if len(joint_names) == n_joints else tuple(f"joint{k + 1}" for k in range(n_joints))
    columns: dict[str, Values] = {
        "run": [states.runs[k].name for k in states.run],
        "row": states.row,
        "time_s": states.time,
        "hold_s": states.hold,
    }
    columns |= {f"{name}_{'m' if name in prismatic else 'rad'}": states.joints[:, k] for k, name in enumerate(names)}
    columns |= {f"{names[k]}_torque_Nm": states.joint_torque[:, k] for k in range(states.joint_torque.shape[1])}
    columns |= {f"{names[k]}_approach": states.approach[:, k] for k in range(states.approach.shape[1])}
    columns |= {name: states.wrench[:, k] for k, name in enumerate(_WRENCH)}
    quaternions = quaternion_from_rotation(states.rotation)
    for b, target in enumerate(states.setup.target_names):
        columns |= {f"{target}_{axis}_m": states.position[:, b, k] for k, axis in enumerate("xyz")}
        columns |= {f"{target}_q{axis}": quaternions[:, b, k] for k, axis in enumerate("wxyz")}
        columns |= {f"{target}_d{axis}_m": states.deflection[:, b, k] for k, axis in enumerate("xyz")}
        columns |= {f"{target}_r{axis}_rad": states.deflection[:, b, 3 + k] for k, axis in enumerate("xyz")}
        if np.isfinite(states.sigma[:, b]).any():
            columns |= {f"{target}_{axis}_sigma_m": states.sigma[:, b, k] for k, axis in enumerate("xyz")}
            columns |= {f"{target}_r{axis}_sigma_rad": states.sigma[:, b, 3 + k] for k, axis in enumerate("xyz")}
        columns |= {f"{target}_{axis}_scatter_m": states.position_scatter[:, b, k] for k, axis in enumerate("xyz")}
    columns |= _markers_columns(states)
    columns |= {f"{rod}_length_m": states.lengths[:, k] for k, rod in enumerate(states.setup.rod_names)}
    columns |= {
        f"{gauge.name}_displacement_m": states.displacement[:, k] for k, gauge in enumerate(states.setup.gauges)
    }
    columns["reference"] = states.reference
    columns |= {f"temperature{k + 1}": states.temperature[:, k] for k in range(states.temperature.shape[1])}
    columns["n_readings"] = states.n_readings
    columns |= {_scatter_name(name): states.wrench_scatter[:, k] for k, name in enumerate(_WRENCH)}
    if np.isfinite(states.motor_sigma).any():
        columns["motor_angle_sigma_rad"] = states.motor_sigma
        columns |= {_scatter_name(name, "sigma"): states.wrench_sigma[:, k] for k, name in enumerate(_WRENCH)}
    columns["set_aside"] = [str(reason) for reason in states.set_aside]
    columns["set_aside_code"] = [str(code) for code in states.set_aside_code]
    table = table_of(columns)
    document = {"schema": SCHEMA, "joints": list(names)} | _setup_document(states)
    return table.replace_schema_metadata({TABLE_DOCUMENT: json.dumps(document)})


def states_from_table(table: pa.Table) -> LoadStates:
    """Return the load states of a table that `states_table` made.

    Raises
    ------
    ValueError
        The table carries no setup, or one of another version.
    """
    document = json.loads((table.schema.metadata or {}).get(TABLE_DOCUMENT, b"{}"))
    if document.get("schema") != SCHEMA:
        raise ValueError(f"this table is not {SCHEMA}; ingest again")
    runs = tuple(
        RunInfo(
            run["name"],
            run["experiment"],
            run["holdout"],
            tuple(run["tags"]),
            run.get("compensated", False),
            _fixture(run),
            of=run.get("of", ""),
            motor_torque=run.get("motor_torque", False),
            direct=run.get("direct", False),
            tracker=run.get("tracker", 0),
            measures=None if run["measures"] is None else StateMeasure(run["measures"]),
        )
        for run in document["runs"]
    )
    swept = {run["name"] for run in document["runs"] if run.get("swept")}
    runs = tuple(replace(run, swept=run.name in swept) for run in runs)
    number = {run.name: k for k, run in enumerate(runs)}
    setup = _setup(document["setup"])
    targets = setup.target_names

    def block(names: list[str]) -> Floats:
        columns = [values_of(table.column(name)) for name in names]
        return np.stack(columns, axis=1).astype(np.float64) if columns else np.zeros((table.num_rows, 0))

    def of_targets(pattern: str, axes: str) -> Floats:
        blocks = [block([pattern.format(t, axis) for axis in axes]) for t in targets]
        return np.stack(blocks, axis=1) if blocks else np.zeros((table.num_rows, 0, len(axes)))

    def stated(pattern: str) -> Floats:
        """Return (n, B, 3) columns that stand in the table for some targets alone."""
        nothing = np.full((table.num_rows, 3), np.nan)
        blocks = [
            block([pattern.format(t, axis) for axis in "xyz"])
            if pattern.format(t, "x") in table.column_names
            else nothing
            for t in targets
        ]
        return np.stack(blocks, axis=1) if blocks else np.zeros((table.num_rows, 0, 3))

    torques = [f"{name}_torque_Nm" for name in document["joints"]]
    approaches = [f"{name}_approach" for name in document["joints"]]
    temperatures = [name for name in table.column_names if name.startswith("temperature")]
    deflection = np.concatenate([of_targets("{}_d{}_m", "xyz"), of_targets("{}_r{}_rad", "xyz")], axis=2)
    return LoadStates(
        runs=runs,
        run=np.array([number[name] for name in values_of(table.column("run"))], dtype=np.int64),
        time=block(["time_s"])[:, 0],
        hold=block(["hold_s"])[:, 0],
        joints=block(
            [f"{name}_m" if f"{name}_m" in table.column_names else f"{name}_rad" for name in document["joints"]]
        ),
        wrench=block(list(_WRENCH)),
        position=of_targets("{}_{}_m", "xyz"),
        rotation=rotation_from_quaternion(of_targets("{}_q{}", "wxyz")),
        deflection=deflection,
        reference=values_of(table.column("reference")),
        temperature=block(temperatures),
        row=values_of(table.column("row")).astype(np.int64),
        n_readings=values_of(table.column("n_readings")).astype(np.int64),
        wrench_scatter=block([_scatter_name(name) for name in _WRENCH]),
        position_scatter=of_targets("{}_{}_scatter_m", "xyz"),
        set_aside=values_of(table.column("set_aside")),
        setup=setup,
        lengths=block([f"{rod}_length_m" for rod in setup.rod_names]),
        displacement=block([f"{gauge.name}_displacement_m" for gauge in setup.gauges]),
        markers_measured=_markers_measured(table, setup),
        sigma=np.concatenate([stated("{}_{}_sigma_m"), stated("{}_r{}_sigma_rad")], axis=2),
        joint_torque=block([name for name in torques if name in table.column_names]),
        approach=block([name for name in approaches if name in table.column_names]),
        set_aside_code=values_of(table.column("set_aside_code")),
        **_clamped_sigma(table),
    )


def _clamped_sigma(table: pa.Table) -> dict[str, Floats]:
    """Return the uncertainties that states of clamped runs carry; nothing where there are none."""
    if "motor_angle_sigma_rad" not in table.column_names:
        return {}
    names = [_scatter_name(name, "sigma") for name in _WRENCH]
    return {
        "motor_sigma": np.asarray(values_of(table.column("motor_angle_sigma_rad")), dtype=np.float64),
        "wrench_sigma": np.stack([values_of(table.column(name)) for name in names], axis=1).astype(np.float64),
    }


def _markers_columns(states: LoadStates) -> dict[str, list[str]]:
    """Return, by target whose poses come from points, the measured points: their names with commas between."""
    columns = {}
    for b, markers in enumerate(states.setup.markers):
        if markers is not None:
            mask = states.markers_measured[:, b, : len(markers.names)]
            patterns, number = np.unique(mask, axis=0, return_inverse=True)
            texts = [
                ",".join(name for name, measured in zip(markers.names, row, strict=True) if measured)
                for row in patterns
            ]
            columns[f"{states.setup.target_names[b]}_markers"] = [texts[k] for k in number.reshape(-1)]
    return columns


def _markers_measured(table: pa.Table, setup: MeasurementSetup) -> NDArray[np.bool_]:
    """Return (n, B, K) which points were measured, from the table's text."""
    most = max((len(markers.names) for markers in setup.markers if markers is not None), default=0)
    result = np.zeros((table.num_rows, len(setup.targets), most), dtype=np.bool_)
    for b, markers in enumerate(setup.markers):
        if markers is not None:
            words, number = np.unique(values_of(table.column(f"{setup.target_names[b]}_markers")), return_inverse=True)
            rows = np.array([[name in str(word).split(",") for name in markers.names] for word in words])
            result[:, b, : len(markers.names)] = rows[number]
    return result


def _fixture(run: Document) -> tuple[tuple[float, ...], ...] | None:
    rows = run.get("fixture")
    return None if rows is None else tuple(tuple(float(item) for item in row) for row in rows)


def _scatter_name(name: str, what: str = "scatter") -> str:
    """Return ``Fx_scatter_N`` for ``Fx_N``."""
    component, unit = name.split("_")
    return f"{component}_{what}_{unit}"


def _setup_document(states: LoadStates) -> Document:
    setup = states.setup
    return {
        "runs": [
            {"name": run.name, "experiment": run.experiment, "measures": run.measures}
            | {"holdout": run.holdout, "tags": list(run.tags)}
            | ({"compensated": True} if run.compensated else {})
            | ({"swept": True} if run.swept else {})
            | ({"of": run.of} if run.of else {})
            | ({"motor_torque": True} if run.motor_torque else {})
            | ({"direct": True} if run.direct else {})
            | ({"tracker": run.tracker} if run.tracker else {})
            | ({"fixture": [list(row) for row in run.fixture]} if run.fixture is not None else {})
            for run in states.runs
        ],
        "setup": {
            "wrench_axes": _attachment_document(setup.wrench_axes),
            "wrench_point": _attachment_document(setup.wrench_point),
            "targets": [_attachment_document(target) for target in setup.targets],
            "target_names": list(setup.target_names),
            "moments_measured": setup.moments_measured,
            "trackers": [
                {"frame": tracker.frame, "base_from_frame": tracker.base_from_frame.tolist()}
                for tracker in setup.trackers
            ],
            "estimated": list(setup.estimated),
            "load_is_weight": setup.load_is_weight,
            "load_point_sigma_m": setup.load_point_sigma,
            "torque_gain_sigma": setup.torque_gain_sigma,
            "tool_mass_kg": setup.tool_mass,
            "tool_com_m": setup.tool_com.tolist(),
            "sigma": {
                "translation_m": setup.sigma.translation,
                "rotation_rad": setup.sigma.rotation,
                "force_N": setup.sigma.force,
                "moment_Nm": setup.sigma.moment,
                "length_m": setup.sigma.length,
                "gauge_m": setup.sigma.gauge,
                "motor_angle_rad": setup.sigma.motor_angle,
                "absolute_translation_m": setup.sigma.absolute_translation,
                "absolute_rotation_rad": setup.sigma.absolute_rotation,
            },
            "tared": setup.tared,
            "markers": [
                None if markers is None else {"names": list(markers.names), "places_m": markers.places.tolist()}
                for markers in setup.markers
            ],
            "rods": [_rods_document(rods, beam) for rods, beam in zip(setup.rods, setup.beams, strict=True)],
            "gauges": [
                {
                    "name": gauge.name,
                    "target": gauge.target,
                    "axes": _attachment_document(gauge.axes),
                    "direction": gauge.direction.tolist(),
                }
                for gauge in setup.gauges
            ],
        },
    }


def _attachment_document(attachment: Attachment) -> Document:
    return {"body": attachment.body, "transform": attachment.transform.tolist()}


def _attachment(document: Document) -> Attachment:
    return Attachment(int(document["body"]), np.array(document["transform"], dtype=np.float64))


def _setup(document: Document) -> MeasurementSetup:
    sigma = document["sigma"]
    return MeasurementSetup(
        wrench_axes=_attachment(document["wrench_axes"]),
        wrench_point=_attachment(document["wrench_point"]),
        targets=tuple(_attachment(target) for target in document["targets"]),
        target_names=tuple(document["target_names"]),
        moments_measured=bool(document["moments_measured"]),
        trackers=tuple(
            TrackerPlace(str(tracker["frame"]), np.array(tracker["base_from_frame"], dtype=np.float64))
            for tracker in document["trackers"]
        ),
        estimated=tuple(document.get("estimated", ())),
        load_is_weight=bool(document.get("load_is_weight", False)),
        load_point_sigma=float(document.get("load_point_sigma_m", 0.0)),
        torque_gain_sigma=float(document.get("torque_gain_sigma", 0.0)),
        tool_mass=float(document["tool_mass_kg"]),
        tool_com=np.array(document["tool_com_m"], dtype=np.float64),
        sigma=Sigma(
            sigma["translation_m"], sigma["rotation_rad"], sigma["force_N"], sigma["moment_Nm"],
            sigma.get("length_m"), sigma.get("gauge_m"), sigma.get("motor_angle_rad"),
            sigma.get("absolute_translation_m"), sigma.get("absolute_rotation_rad"),
        ),
        tared=str(document["tared"]),
        rods=tuple(_rods(rods) for rods in document.get("rods", ())),
        beams=tuple(_beam(rods["beam"]) for rods in document.get("rods", ())),
        gauges=tuple(
            Gauge(gauge["name"], int(gauge["target"]), _attachment(gauge["axes"]), np.array(gauge["direction"]))
            for gauge in document.get("gauges", ())
        ),
        markers=tuple(
            None if body is None else Markers(tuple(body["names"]), np.array(body["places_m"], dtype=np.float64))
            for body in document.get("markers", ())
        ),
    )  # fmt: skip


def _rods_document(rods: Rods, beam: BeamProperties) -> Document:
    """Return the rods on one link; JSON has no NaN, null stands for what is not known."""
    return {
        "link": rods.link,
        "names": list(rods.names),
        "start_m": rods.start.tolist(),
        "end_m": rods.end.tolist(),
        "warping_m2": _nan_as_null(rods.warping),
        "sigma_m": _nan_as_null(rods.sigma),
        "beam": {
            "length_m": beam.length,
            "neutral_m": list(beam.neutral),
            "twist_centre_m": list(beam.twist_centre),
            "warping_decay_m": beam.warping_decay,
            "warping_hold": beam.warping_hold,
        },
    }


def _nan_as_null(values: Floats) -> Any:
    return [None if not np.isfinite(value) else value for value in values.ravel().tolist()]


def _rods(document: Document) -> Rods:
    start, end, warping, sigma = (
        np.array(document[key], dtype=np.float64) for key in ("start_m", "end_m", "warping_m2", "sigma_m")
    )
    return Rods(document["link"], tuple(document["names"]), start, end, warping.reshape(-1, 2), sigma)


def _beam(document: Document) -> BeamProperties:
    y, z = document["neutral_m"]
    sy, sz = document["twist_centre_m"]
    return BeamProperties(document["length_m"], (y, z), (sy, sz), document["warping_decay_m"], document["warping_hold"])
