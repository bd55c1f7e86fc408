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

from stiffcal.report.content import (
    Driver,
    Floats,
    Instrument,
    Integers,
    LoadPath,
    Provenance,
    ReportContent,
    ReportRun,
    ReportStates,
    SetAside,
    SourceFile,
)

SHARED = Path(__file__).resolve().parents[3] / "shared"


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


def rms(residual: Floats) -> float:
    """Root mean squared length of (n, 3)."""
    return float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))) if residual.size else 0.0


def measures(residual: Floats) -> dict[str, float | None]:
    """The interface's {translation, rotation} of (n, 3) or (n, 6)."""
    return {
        "translation": rms(residual[:, :3]),
        "rotation": rms(residual[:, 3:]) if residual.shape[1] == 6 else None,
    }


def largest(residual: Floats) -> dict[str, float | None]:
    """The longest residual, as in the interface."""
    return {
        "translation": float(np.linalg.norm(residual[:, :3], axis=1).max()),
        "rotation": float(np.linalg.norm(residual[:, 3:], axis=1).max()) if residual.shape[1] == 6 else None,
    }


def breakdown(labels: np.ndarray[Any, Any], residual: Floats, order: list[str]) -> list[dict[str, Any]]:
    """`by_…` lists of the validate document."""
    out = []
    for label in order:
        pick = labels == label
        if pick.any():
            out.append(
                {"label": label, "low": None, "high": None, "n": int(pick.sum()), "rms": measures(residual[pick]),
                 "max": largest(residual[pick])}
            )  # fmt: skip
    return out


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


def documents(
    joint_names: tuple[str, ...],
    c: Floats,
    covariance: Floats,
    states: ReportStates,
    run_names: list[str],
    noise: dict[str, float] | None,
) -> dict[str, Any]:
    """identify, validate and history documents in the interface's form."""
    parameters = []
    for k in range(len(joint_names)):
        std = float(np.sqrt(covariance[k, k]))
        low, high = c[k] - 1.96 * std, c[k] + 1.96 * std
        parameters.append(
            {
                "name": f"joint-compliance.j{k + 1}.c", "effect": "joint-compliance", "where": {"joints": [k + 1]},
                "value": float(c[k]), "std": std, "interval": [float(low), float(high)], "unit": "rad/(N*m)",
                "fixed": False, "identifiable": True, "stiffness": float(1 / c[k]),
                "stiffness_std": float(std / c[k] ** 2),
                "stiffness_interval": [float(1 / high), float(1 / low) if low > 0 else None],
            }
        )  # fmt: skip
    used = states.used
    fit_residual = (states.measured - states.predicted)[used]
    unseen = states.residual[used]
    names = np.array(run_names)[states.run[used]]
    joint = {"schema": "stiffcal/identify/1", "warnings": []}
    identify = joint | {
        "model": {"balance": "first-order", "effects": [{"type": "joint-compliance", "joints": "all"}]},
        "parameters": parameters, "n_states": int(used.sum()), "n_runs": len(run_names), "rms": measures(fit_residual),
        "noise": noise, "noise_source": "repeats" if noise else "none", "reduced_chi2": 1.02 if noise else None,
        "condition": 31.0, "not_identifiable": [], "rejected": [],
    }  # fmt: skip
    loads = states.load[used]
    edges = np.quantile(loads, [0, 0.33, 0.67, 1.0])
    bins = np.clip(np.searchsorted(edges, loads, side="right") - 1, 0, 2)
    load_names = [f"{edges[i]:.0f} … {edges[i + 1]:.0f} N" for i in range(3)]
    by_load = breakdown(np.array(load_names)[bins], unseen, load_names)
    axis = np.argmax(np.abs(states.force[used]), axis=1)
    positive = states.force[used][np.arange(len(axis)), axis] > 0
    mostly = np.array([f"mostly {'+' if up else '−'}{'xyz'[a]}" for a, up in zip(axis, positive, strict=True)])
    zero = measures(states.measured[used])
    order = np.argsort(-np.linalg.norm(unseen[:, :3], axis=1))[:5]
    validate = {
        "schema": "stiffcal/validate/1", "warnings": [], "rms": measures(unseen), "max": largest(unseen),
        "noise": noise, "relative": {k: (v / z if v and (z := zero[k]) else None) for k, v in measures(unseen).items()},
        "zero_model": zero, "scheme": f"leave one pose out, {len(run_names)} folds",
        "by_run": breakdown(names, unseen, run_names),
        "by_direction": breakdown(mostly, unseen, [f"mostly {sign}{axis}" for axis in "xyz" for sign in "+−"]),
        "by_load": by_load, "by_branch": breakdown(states.branch[used], unseen, ["loading", "unloading"]),
        "by_joint_angle": [], "passed": True,
        "worst": [
            {"run": str(names[i]), "row": int(i), "residual_m": float(np.linalg.norm(unseen[i, :3])),
             "load": float(loads[i]), "branch": str(states.branch[used][i])}
            for i in order
        ],
    }  # fmt: skip
    history = {
        "schema": "stiffcal/history/1", "warnings": [],
        "fits": [
            {"id": "1", "time": "2026-11-21T10:02:11Z", "model": ["joint-compliance 2,3"],
             "heldout_rms": {k: (0.4 * v if v else None) for k, v in zero.items()},
             "fit_rms": {k: (0.38 * v if v else None) for k, v in zero.items()}, "noise": noise},
            {"id": "2", "time": "2026-11-21T10:09:40Z", "model": ["joint-compliance 1-6"],
             "heldout_rms": measures(unseen), "fit_rms": measures(fit_residual), "noise": noise},
            {"id": "3", "time": "2026-11-21T10:12:02Z", "model": ["joint-compliance 1-6", "backlash 4"],
             "heldout_rms": None, "fit_rms": None, "noise": noise},
        ],
    }  # fmt: skip
    return {"identify": identify, "validate": validate, "history": history}


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


def practice_content(folder: str = "01", max_runs: int | None = None) -> ReportContent:
    """Content from a practice campaign's table of states."""
    root = SHARED / "practice" / folder
    manifest = tomllib.loads((root / "campaign.toml").read_text())
    robot = tomllib.loads((root / "robot.toml").read_text())
    table = root / "raw" / "states.csv"
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    names = list(dict.fromkeys(row["run"] for row in rows))[:max_runs]
    rows = [row for row in rows if row["run"] in names]
    joint_names = tuple(joint["name"] for joint in robot["joints"])
    run = np.array([names.index(row["run"]) for row in rows])
    q = np.deg2rad([[float(row[j]) for j in joint_names] for row in rows])
    wrench = np.array([[float(row[c]) for c in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")] for row in rows])
    dh = [
        (np.deg2rad(j["alpha_deg"]), j["a_m"], np.deg2rad(j["theta_deg"]), j["d_m"]) for j in robot["joints"]
    ]  # fmt: skip
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
    position = np.array([[float(row[c]) * 1e-3 for c in "XYZ"] for row in rows]) @ tracker.T
    first = np.array([int(np.flatnonzero(run == r)[0]) for r in run])
    measured = position - position[first]
    position_only = "q0" not in rows[0]
    if not position_only:
        seen = tracker @ quaternion_matrix(
            np.array([[float(row[c]) for c in ("q0", "qx", "qy", "qz")] for row in rows])
        )
        measured = np.concatenate([measured, rotation_vector(seen @ seen[first].transpose(0, 2, 1))], axis=1)
    size = measured.shape[1]
    change = in_base - in_base[first]
    torque = np.einsum("nij,ni->nj", jacobian(frames, point["ft_sensor"]), change)
    columns = (jacobian(frames, point["target"]) * torque[:, None, :])[:, :size]
    sigma = np.array([1.6e-5] * 3 + [3e-5] * 3)[:size] * np.sqrt(2)
    c, covariance = fit_compliances(columns, measured, sigma)
    labels, branches = direction_labels(change[:, :3], run)
    reference = np.zeros(len(run), dtype=bool)
    reference[first] = True
    aside = np.full(len(run), "", dtype="U60")
    aside[5] = "0.31 mm off its three repeats"
    states = ReportStates(
        run=run, force=change[:, :3], load=np.linalg.norm(change[:, :3], axis=1), direction=labels, branch=branches,
        measured=measured, predicted=with_offsets(columns @ c, measured, run),
        predicted_unseen=with_offsets(leave_one_out(columns, measured, sigma, run), measured, run),
        set_aside=aside, reference=reference,
    )  # fmt: skip
    noise = {"translation": 2.77e-5} | ({} if position_only else {"rotation": 5.2e-5})
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
    root = SHARED / "data" / "fanuc-r2000ic"
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
        predicted_unseen=leave_one_out(columns, measured, np.ones(3), run),
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
