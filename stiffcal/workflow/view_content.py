"""From what lies in the store to what the page for a browser shows."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.manifest import Run
from stiffcal.diagnosis.results import ProposedEffect
from stiffcal.experiments import all_kinds
from stiffcal.identification.state_loads import torques_about_joints
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.model.campaign_effects import placed_robot
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.equilibrium import solve_balance
from stiffcal.reduction.logs import place_of_row
from stiffcal.report.content import ReportStates
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.store import values_of
from stiffcal.view.content import (
    ViewContent,
    ViewModel,
    ViewRun,
    ViewStates,
    ViewVariable,
)
from stiffcal.workflow.diagnose import current_diagnosis
from stiffcal.workflow.experiments import runs_with_fits
from stiffcal.workflow.report_content import report_states_of
from stiffcal.workflow.steps import Ingested
from stiffcal.workflow.view_effects import view_effects
from stiffcal.workflow.view_models import view_models
from stiffcal.workflow.view_motors import motor_states

if TYPE_CHECKING:
    from stiffcal.mechanics.chain import Chain

MOST_SHOWN = 5000
"""States that are drawn; of more a sample."""
ALWAYS_SHOWN = 0.1
"""Share of the sample that is kept for the largest residuals."""
BRANCHES = ["loading", "unloading", "not loaded"]
DEGREES = 180.0 / np.pi
MICRO = 1e6
MEASURES: tuple[Literal["translation", "motor_angle", "length", "torque"], ...] = (
    "translation", "motor_angle", "length", "torque",
)  # fmt: skip


def view_content(data: Ingested, identified: IdentifyResult, validation: ValidateResult, raw: bool) -> ViewContent:
    """Gather everything that the page shows.

    Parameters
    ----------
    data : the campaign with its states.
    identified : the present fit. validation : of it.
    raw : whether readings and names of logs are shown.
    """
    campaign = data.campaign
    diagnosis, reason = current_diagnosis(data, identified)
    measured = runs_with_fits(data)
    pages = [page for kind in all_kinds() if (page := kind.page(measured, identified)) is not None]
    content = ViewContent(
        campaign=campaign.name,
        robot=campaign.robot.name or campaign.chain.name or "robot",
        fit_id=identified.fit_id,
        verdict=reason if diagnosis is None else diagnosis.summary,
        noise=identified.noise if diagnosis is None else diagnosis.noise or identified.noise,
        zero=validation.zero_model,
        suspected=[]
        if diagnosis is None
        else sorted({joint for entry in diagnosis.missing for joint in entry.where.joints or ()}),
        n_states=len(data.states),
        joints=list(data.joint_names),
        rotation=False,
        one_direction=False,
        measure=_measure(identified),
        runs=_runs(data, raw),
        states=None,
        variables=[],
        models=[],
        effects=[],
        readings={},
        raw=raw,
        pages=pages,
        refits_missing="",
    )
    if len(data.states):
        return _with_states(content, data, identified, raw, reason)
    return replace(content, models=view_models(data, identified, [], np.zeros(0, dtype=np.bool_), 3))


def _measure(identified: IdentifyResult) -> Literal["translation", "motor_angle", "length", "torque"]:
    """Return the first measure that the fit has an error in."""
    known = {name for name, value in identified.rms.items() if value is not None}
    for name in MEASURES:
        if name in known:
            return name
    return "translation"


def _joints_of(missing: Sequence[ProposedEffect]) -> list[int]:
    return sorted({joint for entry in missing for joint in entry.where.joints or ()})


def _with_states(
    content: ViewContent, data: Ingested, identified: IdentifyResult, raw: bool, reason: str
) -> ViewContent:
    states, drawn = data.states, report_states_of(data)
    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    torque = torques_about_joints(states, robot)
    variables = _variables(data, drawn, torque)
    measured, own = drawn.measured, None
    if content.measure == "motor_angle":
        measured, own = motor_states(robot, states)
    models = view_models(data, identified, variables, drawn.used, measured.shape[1], own)
    pick = _sample(drawn.residual if own is None else own)
    shown = data.states.select(pick)
    positions, target = _shape(robot, shown)
    missing = [model for model in models if model.kind == "with"]
    return replace(
        content,
        rotation=drawn.has_rotation,
        one_direction=drawn.along is not None,
        states=ViewStates(
            run=states.run[pick],
            row=states.row[pick],
            used=drawn.used[pick],
            why=[str(text) for text in states.set_aside[pick]],
            measured=measured[pick],
            force=drawn.force[pick],
            shape=positions,
            target=target,
        ),
        variables=[replace(variable, values=variable.values[pick]) for variable in variables],
        models=[_picked(model, pick) for model in models],
        effects=view_effects(robot, states, pick, measured.shape[1]),
        readings=_readings(data.table, pick) if raw else {},
        refits_missing="" if missing else reason or "the store holds no refits: run stiffcal diagnose again",
    )


def _picked(model: ViewModel, pick: Integers) -> ViewModel:
    inside, outside = model.residual_fit, model.residual_heldout
    return replace(
        model,
        residual_fit=None if inside is None else inside[pick],
        residual_heldout=None if outside is None else outside[pick],
    )


def _sample(residual: Floats) -> Integers:
    """Return the states that are drawn, ascending: all, or those with the largest residuals and evenly of the rest."""
    n = len(residual)
    if n <= MOST_SHOWN:
        return np.arange(n)
    squares = np.nansum(residual[:, :3] ** 2, axis=1)
    largest = np.argsort(-squares, kind="stable")[: int(ALWAYS_SHOWN * MOST_SHOWN)]
    rest = np.setdiff1d(np.arange(n), largest)
    even = rest[np.linspace(0, len(rest) - 1, MOST_SHOWN - len(largest)).astype(np.int64)]
    return np.asarray(np.union1d(largest, even))


def _runs(data: Ingested, raw: bool) -> list[ViewRun]:
    states, chain, manifest = data.states, data.campaign.chain, data.campaign.manifest
    described = {run.id: run for run in manifest.runs}
    tables = [name for name, source in manifest.sources.items() if source.is_states]
    rows = []
    for info, members in zip(states.runs, states.members(), strict=True):
        joints = states.joints[members[:1]] if len(members) else np.zeros((1, states.joints.shape[1]))
        points, _ = body_poses(chain, chain.model_angles(joints))
        run = described.get(info.name)
        files: list[str] = []
        if raw:
            for name, source in manifest.sources.items():
                files += manifest.files_of(name, run).values() if source.in_files else []
        table = tables[0] if tables and raw else ""
        rows.append(
            ViewRun(
                name=info.name,
                chain=points[0],
                holdout=info.holdout,
                files=list(dict.fromkeys(files)),
                source=table,
                own_file=bool(table) and run is not None and table in run.files,
                first_row=_first_row(data, table, run) if table else "",
            )
        )
    return rows


def _first_row(data: Ingested, source: str, run: Run | None) -> str:
    """Return where the first data row of a source's file stands, in words; "" where the file cannot be looked at."""
    settings = data.campaign.manifest.sources[source]
    file = data.campaign.manifest.files_of(source, run).get("")
    if file is None or not settings.in_files or not (data.campaign.folder / file).is_file():
        return ""
    return place_of_row(data.campaign.folder, settings, file, 1)


def _variables(data: Ingested, drawn: ReportStates, torque: Floats) -> list[ViewVariable]:
    """Return what a residual may follow, over all states."""
    states, names = data.states, data.joint_names
    nowhere = np.zeros(len(states))
    moment = np.asarray(states.wrench[:, 3:])
    found = [
        *(("torque", k + 1, f"torque on joint {k + 1}", "N·m", column) for k, column in enumerate(torque.T)),
        *(("angle", k + 1, f"angle of {names[k]}", "°", DEGREES * column) for k, column in enumerate(states.joints.T)),
        ("load", 0, "load", "N", drawn.load),
        *(("force", k + 1, f"force along {'xyz'[k]}", "N", column) for k, column in enumerate(drawn.force.T)),
        *(
            ("moment", k + 1, f"moment about {'xyz'[k]} of the sensor", "N·m", column)
            for k, column in enumerate(moment.T)
        ),
        ("deflection", 0, "size of the deflection", "µm", MICRO * np.linalg.norm(drawn.measured[:, :3], axis=1)),
        ("time", 0, "time", "s", states.time),
        ("hold", 0, "time under load", "s", states.hold),
        *(("temperature", k + 1, f"temperature {k + 1}", "", column) for k, column in enumerate(states.temperature.T)),
    ]
    variables = [
        ViewVariable(name=f"{name}{number or ''}", label=label, unit=unit, values=values)
        for name, number, label, unit, values in found
        if np.isfinite(values).any() and np.nanmax(values) > np.nanmin(values)
    ]
    branch = nowhere + 2.0
    for number, word in enumerate(BRANCHES[:2]):
        branch[drawn.branch == word] = number
    if np.unique(branch).size > 1:
        variables.append(ViewVariable(name="branch", label="branch", unit="", values=branch, levels=BRANCHES))
    runs = [run.name for run in states.runs]
    variables.append(ViewVariable(name="run", label="run", unit="", values=states.run.astype(np.float64), levels=runs))
    labels = sorted(set(drawn.direction.tolist()))
    if len(labels) > 1:
        numbers = np.searchsorted(np.array(labels), drawn.direction).astype(np.float64)
        words = [label or "not loaded" for label in labels]
        variables.append(
            ViewVariable(name="direction", label="direction of the load", unit="", values=numbers, levels=words)
        )
    return variables


def _shape(robot: CompliantRobot, states: LoadStates) -> tuple[Floats, Floats]:
    """Return how far the chain's points move under the load (n, K, 3), and the measured point at rest (n, 3), m."""
    chain: Chain = robot.chain
    bodies = tuple(Attachment(body, np.eye(4)) for body in range(chain.n_joints + 2))
    setup = replace(states.setup, targets=bodies, target_names=tuple(map(str, range(len(bodies)))))
    angles = chain.model_angles(states.joints)
    balance = solve_balance(robot, angles, np.nan_to_num(states.wrench), setup)
    target, _ = attached_poses(chain, angles, states.setup.targets[0])
    return balance.displacement[:, :, :3], target


_ORDINARY = re.compile(r".*_scatter_|n_readings|.*_sigma_")


def _readings(table: pa.Table, pick: Integers) -> dict[str, Floats]:
    """Return the numbers that the store holds of the drawn states, by column; without those of scatter."""
    numbers = [
        entry.name for entry in table.schema if pa.types.is_floating(entry.type) and not _ORDINARY.match(entry.name)
    ]
    columns = {name: np.asarray(values_of(table.column(name)), dtype=np.float64)[pick] for name in numbers}
    return {name: values for name, values in columns.items() if np.isfinite(values).any()}
