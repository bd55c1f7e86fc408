"""Content for report tests: practice campaigns and the FANUC measurements with a throw-away first-order fit.

Nothing here is stiffcal's physics: a plain linear fit (paper 002, eq. 9 and 10), good enough for pages to look real.
"""

from __future__ import annotations

import csv
import hashlib
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.compensation.predict_result import LoadPath
from stiffcal.report.content import (
    Driver,
    Floats,
    Instrument,
    Integers,
    Provenance,
    ReportContent,
    ReportRun,
    ReportStates,
    SetAside,
    SourceFile,
)
from tests.laboratory.hidden_campaigns import folder_of
from tests.laboratory.report_documents import documents

FANUC = Path(__file__).resolve().parents[3] / "shared" / "data" / "fanuc-r2000ic"


def rotation_z(angle: Floats) -> Floats:
    """(n,) rad to (n, 4, 4)."""
    out = np.tile(np.eye(4), (angle.shape[0], 1, 1))
    out[:, 0, 0] = out[:, 1, 1] = np.cos(angle)
    out[:, 1, 0] = np.sin(angle)
    out[:, 0, 1] = -np.sin(angle)
    return out


def quaternion_matrix(q: Floats) -> Floats:
    """(..., 4) w x y z to (..., 3, 3)."""
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotation_vector(rotation: Floats) -> Floats:
    """(n, 3, 3) small rotations to (n, 3) rad."""
    r = rotation
    return 0.5 * np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=-1)


def joint_frames(rows: list[tuple[float, float, float, float]], q: Floats) -> Floats:
    """Modified DH (alpha, a, theta offset, d) and (n, J) rad to (n, J + 1, 4, 4), base first."""
    frames = [np.tile(np.eye(4), (q.shape[0], 1, 1))]
    for k, (alpha, a, theta, d) in enumerate(rows):
        fixed = np.eye(4)
        fixed[:3, :3] = [[1, 0, 0], [0, np.cos(alpha), -np.sin(alpha)], [0, np.sin(alpha), np.cos(alpha)]]
        fixed[0, 3] = a
        turn = rotation_z(q[:, k] + theta)
        turn[:, 2, 3] = d
        frames.append(frames[-1] @ fixed @ turn)
    return np.stack(frames, axis=1)


def jacobian(frames: Floats, point: Floats) -> Floats:
    """(n, 6, J) of a point (n, 3) in base axes."""
    axis, origin = frames[:, 1:, :3, 2], frames[:, 1:, :3, 3]
    return np.concatenate([np.cross(axis, point[:, None] - origin), axis], axis=-1).transpose(0, 2, 1)


def fit_compliances(columns: Floats, deflection: Floats, sigma: Floats) -> tuple[Floats, Floats]:
    """Weighted least squares over (n, m, J) and (n, m): compliances (J,) and covariance scaled by reduced χ²."""
    n, m, joints = columns.shape
    design = (columns / sigma[:, None]).reshape(n * m, joints)
    right = (deflection / sigma).reshape(-1)
    c, cost, *_ = np.linalg.lstsq(design, right, rcond=None)
    covariance = np.linalg.inv(design.T @ design) * float(cost[0]) / (n * m - joints)
    return np.asarray(c, dtype=np.float64), covariance


def direction_labels(force: Floats, run: Integers) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Labels and branches of load states in order: one label per signed direction in a run."""
    labels = np.full(len(run), "", dtype="U8")
    branches = np.full(len(run), "", dtype="U12")
    load = np.linalg.norm(force, axis=1)
    for r in np.unique(run):
        index = np.flatnonzero(run == r)
        known: list[Floats] = []
        previous = 0.0
        for i in index[1:]:
            unit = force[i] / load[i]
            if load[i] > 0.1 * load[index].max():
                fits = [float(unit @ k) for k in known]
                if not fits or max(fits) < 0.9:
                    known.append(unit)
                    fits.append(1.0)
                labels[i] = f"d{int(np.argmax(fits)) + 1}"
            else:
                labels[i] = labels[i - 1]
            branches[i] = "loading" if load[i] > previous else "unloading"
            previous = load[i]
    return labels, branches


def provenance(name: str, robot: str, files: list[Path]) -> Provenance:
    """Provenance with true digests and a fixed date."""
    return Provenance(
        campaign=name,
        robot=robot,
        date="2026-11-21",
        versions=(("stiffcal", "0.1.0"), ("numpy", np.__version__), ("Python", "3.11")),
        sources=tuple(
            SourceFile(f"raw/{p.name}", hashlib.sha256(p.read_bytes()).hexdigest(), p.stat().st_size) for p in files
        ),
        settings=(("balance", "first-order"), ("loss", "linear"), ("weights", "equal")),
    )


def with_offsets(predicted: Floats, measured: Floats, run: Integers) -> Floats:
    """Give each run its own constant offset: the error of its reference reading."""
    out = predicted.copy()
    for r in np.unique(run):
        out[run == r] += (measured - predicted)[run == r].mean(axis=0)
    return out


def leave_one_out(columns: Floats, measured: Floats, sigma: Floats, run: Integers) -> Floats:
    """Prediction of each run by a fit without it."""
    out = np.zeros_like(measured)
    for r in np.unique(run):
        inside = run == r
        c, _ = fit_compliances(columns[~inside], measured[~inside], sigma)
        out[inside] = columns[inside] @ c
    return out


def example_path(jacobian_of_pose: Floats, c: Floats, pose: str) -> LoadPath:
    """The path of paper 002's Fig. 2."""
    up = np.linspace(0, 1, 21)[:, None]
    force = np.concatenate([(1 - up) * [-100.0, 200.0, -300.0], up[1:] * [100.0, -200.0, 100.0]])
    linear = jacobian_of_pose[:3]
    return LoadPath(
        "Ramp through zero", pose, force, force @ (linear @ np.diag(c) @ linear.T).T, corners=(0, 20, 40)
    )  # fmt: skip


def rows_of_runs(table: Path, max_runs: int | None) -> tuple[list[str], list[dict[str, str]]]:
    """Names of the first runs of a table of states, and their rows."""
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    names = list(dict.fromkeys(row["run"] for row in rows))[:max_runs]
    return names, [row for row in rows if row["run"] in names]


def tracked(rows: list[dict[str, str]], tracker: Floats, first: Integers) -> Floats:
    """Displacement since each run's first row, (n, 3) or with orientation (n, 6), base axes."""
    position = np.array([[float(row[c]) * 1e-3 for c in "XYZ"] for row in rows]) @ tracker.T
    measured = position - position[first]
    if "q0" in rows[0]:
        seen = tracker @ quaternion_matrix(
            np.array([[float(row[c]) for c in ("q0", "qx", "qy", "qz")] for row in rows])
        )
        measured = np.concatenate([measured, rotation_vector(seen @ seen[first].transpose(0, 2, 1))], axis=1)
    return measured


def report_states(run: Integers, force: Floats, measured: Floats, predicted: Floats, unseen: Floats) -> ReportStates:
    """States of a report, one of them set aside; each run's offset is free."""
    labels, branches = direction_labels(force, run)
    reference = np.zeros(len(run), dtype=bool)
    reference[np.unique(run, return_index=True)[1]] = True
    aside = np.full(len(run), "", dtype="U60")
    aside[5] = "0.31 mm off its three repeats"
    return ReportStates(
        run=run, force=force, load=np.linalg.norm(force, axis=1), direction=labels, branch=branches,
        measured=measured, predicted=with_offsets(predicted, measured, run),
        predicted_heldout=with_offsets(unseen, measured, run),
        set_aside=aside, reference=reference,
    )  # fmt: skip


def practice_content(folder: str = "01", max_runs: int | None = None) -> ReportContent:
    """Content from a practice campaign's table of states."""
    root = folder_of(folder)
    manifest = tomllib.loads((root / "campaign.toml").read_text())
    robot = tomllib.loads((root / "robot.toml").read_text())
    table = root / "raw" / "states.csv"
    names, rows = rows_of_runs(table, max_runs)
    joint_names = tuple(joint["name"] for joint in robot["joints"])
    run = np.array([names.index(row["run"]) for row in rows])
    q = np.deg2rad([[float(row[j]) for j in joint_names] for row in rows])
    wrench = np.array([[float(row[c]) for c in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")] for row in rows])
    dh = [(np.deg2rad(j["alpha_deg"]), j["a_m"], np.deg2rad(j["theta_deg"]), j["d_m"]) for j in robot["joints"]]
    frames = joint_frames(dh, q)
    flange = np.eye(4)
    flange[:3, 3] = robot["flange"]["xyz_m"]
    flange_frames = frames[:, -1] @ flange
    at = {key: np.array(manifest["frames"][key]["xyz_m"]) for key in ("ft_sensor", "target")}
    point = {key: flange_frames[:, :3, 3] + flange_frames[:, :3, :3] @ at[key] for key in at}
    sensor_axes = flange_frames[:, :3, :3] @ quaternion_matrix(
        np.array(manifest["frames"]["ft_sensor"]["quaternion_wxyz"])
    )
    in_base = np.concatenate([np.einsum("nij,nj->ni", sensor_axes, wrench[:, k : k + 3]) for k in (0, 3)], axis=1)
    tracker = quaternion_matrix(np.array(manifest["frames"]["tracker"]["quaternion_wxyz"]))
    first = np.array([int(np.flatnonzero(run == r)[0]) for r in run])
    measured = tracked(rows, tracker, first)
    size = measured.shape[1]
    change = in_base - in_base[first]
    torque = np.einsum("nij,ni->nj", jacobian(frames, point["ft_sensor"]), change)
    columns = (jacobian(frames, point["target"]) * torque[:, None, :])[:, :size]
    sigma = np.array([1.6e-5] * 3 + [3e-5] * 3)[:size] * np.sqrt(2)
    c, covariance = fit_compliances(columns, measured, sigma)
    unseen = leave_one_out(columns, measured, sigma, run)
    states = report_states(run, change[:, :3], measured, columns @ c, unseen)
    noise = {"translation": 2.77e-5} | ({"rotation": 5.2e-5} if size == 6 else {})
    made = documents(joint_names, c, covariance, states, names, noise)
    starts = [int(np.argmax(run == r)) for r in range(len(names))]
    sticks = [np.concatenate([frames[i, :, :3, 3], flange_frames[i, None, :3, 3]]) for i in starts]
    first_state = jacobian(frames, point["target"])[0]
    return ReportContent(
        provenance=provenance(manifest["name"], robot["name"], [table, root / "campaign.toml", root / "robot.toml"]),
        runs=tuple(
            ReportRun(name, q[starts[r]], sticks[r], point["target"][starts[r]])
            for r, name in enumerate(names)
        ),
        joint_names=joint_names,
        states=states,
        instruments=(
            Instrument("table", "force and moment", "CSV, axes of ft_sensor", None, "0.5 N, 0.1 N·m"),
            Instrument("table", "pose of target", "CSV, axes of tracker", None, "0.016 mm, 0.03 mrad"),
            Instrument("table", "joint angles", "CSV"),
        ),
        set_aside=(SetAside(names[0], (6,), "0.31 mm off its three repeats: cable bumped"),),
        drivers=(
            *(Driver(f"torque on joint {k + 1} ({name})", "N·m", torque[:, k]) for k, name in enumerate(joint_names)),
            Driver("time since the start", "h", np.array([float(row["t"]) for row in rows]) / 3600),
        ),
        load_paths=(example_path(first_state, c, f"the pose of run {names[0]}"),),
        **made,
    )  # fmt: skip


def fanuc_content() -> ReportContent:
    """Content from the FANUC measurements: 43 poses with one state each, noise unknown."""
    root = FANUC
    logged, force, measured = (
        np.loadtxt(root / name, delimiter=",", skiprows=1) for name in ("joint_angles.csv", "forces.csv", "deltaX.csv")
    )
    third = -(logged[:, 1] + logged[:, 2])
    q = np.column_stack([logged[:, 0], logged[:, 1], third, -logged[:, 3:]])
    quarter = np.pi / 2
    dh = [
        (0, 0, 0, 0.670), (-quarter, 0.312, -quarter, 0), (0, 1.075, 0, 0), (-quarter, 0.225, 0, 1.280),
        (quarter, 0, 0, 0), (-quarter, 0, 0, 0.215),
    ]  # fmt: skip
    frames = joint_frames(dh, q)
    point = frames[:, -1, :3, 3] + frames[:, -1, :3, :3] @ np.array([0.0069, 0.2453, 0.3193])
    linear = jacobian(frames, point)[:, :3]
    columns = linear * np.einsum("nij,ni->nj", linear, force)[:, None, :]
    c, covariance = fit_compliances(columns, measured, np.ones(3))
    run = np.arange(len(q))
    names = [f"row{i + 1}" for i in run]
    axis = np.argmax(np.abs(force), axis=1)
    labels = np.array([("+" if force[i, a] > 0 else "−") + "xyz"[a] for i, a in enumerate(axis)])
    states = ReportStates(
        run=run, force=force, load=np.linalg.norm(force, axis=1), direction=labels,
        branch=np.full(len(run), "", dtype="U12"), measured=measured, predicted=columns @ c,
        predicted_heldout=leave_one_out(columns, measured, np.ones(3), run),
    )  # fmt: skip
    joint_names = tuple(f"J{k + 1}" for k in range(6))
    made = documents(joint_names, c, covariance, states, names, None)
    made["identify"]["warnings"] = ["link masses are taken from the authors' configuration"]
    made["identify"]["not_identifiable"] = ["joint 6 is poorly known: the loads turn it by less than 0.1 mrad"]
    for joint in made["validate"]["by_run"]:
        joint["n"] = 1
    return ReportContent(
        provenance=provenance("fanuc-r2000ic", "FANUC R-2000iC", sorted(root.glob("*.csv"))),
        runs=tuple(
            ReportRun(name, logged[i], np.concatenate([frames[i, :, :3, 3], frames[i, -1:, :3, 3]]), point[i])
            for i, name in enumerate(names)
        ),
        joint_names=joint_names,
        states=states,
        instruments=(
            Instrument("table", "force at the tool point", "CSV, base axes"),
            Instrument("table", "displacement of the tool point", "CSV, base axes, loaded minus unloaded"),
            Instrument("table", "joint angles", "CSV, as the controller shows them"),
        ),
        **made,
    )
