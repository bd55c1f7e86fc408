"""From what lies in the store to what the page for a browser shows."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect
from stiffcal.identification.readings.state_loads import torques_about_joints
from stiffcal.kinds import all_kinds
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.measurements.rms import Rms
from stiffcal.measurements.varying import varies
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.quantity import FORCE, LENGTH, MOMENT, of_joint
from stiffcal.report.content import ReportStates
from stiffcal.report.gathering.states import report_states_of
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.show.pages import page_of
from stiffcal.stages.diagnoses.current import current_diagnosis
from stiffcal.stages.experiments import runs_with_fits
from stiffcal.stages.steps import FIT_STATES, Ingested
from stiffcal.validation.schemes import HOLDOUT_RUNS, held_out
from stiffcal.view.content import (
    ViewBody,
    ViewContent,
    ViewStates,
    ViewVariable,
)
from stiffcal.view.gathering.bodies import view_bodies
from stiffcal.view.gathering.candidates import in_model_in_words, sizes_in_words, view_candidates
from stiffcal.view.gathering.change import LastAdded, diagnosis_of_states
from stiffcal.view.gathering.effects import view_effects
from stiffcal.view.gathering.evidence import picked_evidence, view_evidence
from stiffcal.view.gathering.models import names_in, place_words, tables_of_states, view_models
from stiffcal.view.gathering.motors import motor_states, moved_torque
from stiffcal.view.gathering.rows import content_of_rows
from stiffcal.view.gathering.runs import rows_of_logs, spans_of_sweeps, view_runs, with_raw_rows
from stiffcal.view.gathering.sample import picked_model, sample_of

if TYPE_CHECKING:
    from stiffcal.mechanics.chain import Chain

BRANCHES = ["loading", "unloading", "not loaded"]
DEGREES = 180.0 / np.pi
MEASURES: tuple[Literal["translation", "motor_angle", "length", "torque"], ...] = (
    "translation", "motor_angle", "length", "torque",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class EarlierVerdict:
    """A diagnosis that is shown next to another model than the one it is of."""

    diagnosis: DiagnoseResult
    """What it answers."""
    of: str
    """That model, in words."""
    same_states: bool
    """Whether it is of the load states that are shown: what it read of each can be drawn then."""


def view_content(
    data: Ingested,
    identified: IdentifyResult,
    validation: ValidateResult,
    raw: bool,
    earlier: EarlierVerdict | None = None,
    drawn: Integers | None = None,
    alike: ViewContent | None = None,
) -> ViewContent:
    """Gather everything that the page shows.

    Parameters
    ----------
    data : the campaign with its states.
    identified : the present fit. validation : of it.
    raw : whether readings and names of logs are shown.
    earlier : a diagnosis to show where the store has none of the present fit.
    drawn : which states are drawn, ascending; None: all, or of many a sample.
    alike : another page of the same readings and robot: its bodies and what it knows of the logs are taken; None: the
        meshes and logs are read.
    """
    campaign = data.campaign
    diagnosis, reason = current_diagnosis(data, identified)
    diagnosis_of, evidence_known = "", True
    if diagnosis is None and earlier is not None:
        diagnosis, diagnosis_of, evidence_known = earlier.diagnosis, earlier.of, earlier.same_states
    measured = runs_with_fits(data)
    kinds = [(kind.page(measured, identified), kind.drawn_rows(measured, identified)) for kind in all_kinds()]
    rows, of_rows = [row for _, row in kinds if row is not None], bool(len(data.states))
    pages = [page for page, row in kinds if page is not None and (row is None or not of_rows)]
    if diagnosis is not None and not diagnosis_of:
        pages.append(page_of(diagnosis))
    missing = [] if diagnosis is None else diagnosis.missing
    joints, links, suspects = _places_of(missing, placed_robot(campaign))
    bodies: list[ViewBody] = []
    meshes_fault = ""
    if len(data.states) and _measure(identified) != "motor_angle":  # else no robot is drawn
        bodies, meshes_fault = view_bodies(campaign) if alike is None else (alike.bodies, alike.meshes_fault)
    content = ViewContent(
        campaign=campaign.name,
        robot=campaign.robot.name or campaign.chain.name or "robot",
        fit_id=identified.fit_id,
        verdict=reason if diagnosis is None else diagnosis.summary,
        noise=identified.noise if diagnosis is None else diagnosis.noise or identified.noise,
        zero=validation.zero_model,
        suspected=joints,
        suspected_links=links,
        suspects=suspects,
        n_states=len(data.states),
        joints=list(data.joint_names),
        rotation=False,
        one_direction=False,
        measure=_measure(identified),
        direction="direction",
        runs=view_runs(
            data, raw, bool(bodies), {} if alike is None else {run.name: run.first_row for run in alike.runs}
        ),
        states=None,
        variables=[],
        models=[],
        effects=[],
        evidence=[],
        change=None,
        diagnosed=None if diagnosis is None else _diagnosed(diagnosis),
        held_out=held_out(validation.scheme),
        readings={},
        raw=raw,
        pages=pages,
        refits_missing="",
        in_model=in_model_in_words(diagnosis),
        excluded_sizes=sizes_in_words(diagnosis),
        candidates=view_candidates(diagnosis),
        is_diagnosed=diagnosis is not None,
        diagnosis_of=diagnosis_of,
        bodies=bodies,
        meshes_fault=meshes_fault,
    )
    if len(data.states):
        content = _with_states(content, data, identified, diagnosis if evidence_known else None, reason, drawn)
        bare = replace(
            content,
            variables=[],
            effects=[],
            evidence=[],
            readings={},
            diagnosed=None,
            suspected_links=[],
            measure="torque",
            bodies=[],
            meshes_fault="",
            pages=[page for page, row in kinds if page is not None and row is not None],
        )
        return replace(content, others=[content_of_rows(bare, row, data, identified, reason, None) for row in rows[:1]])
    if rows:
        return content_of_rows(content, rows[0], data, identified, reason, drawn)
    return replace(content, models=view_models(data, identified, [], np.zeros(0, dtype=np.bool_), None))


def _diagnosed(diagnosis: DiagnoseResult) -> Rms:
    """Return the present model's error by the scheme of the stored refits: regions of places, else single poses."""
    validated = diagnosis.as_validated
    return diagnosis.rms if validated is None or validated.scheme == HOLDOUT_RUNS else validated.rms


def _measure(identified: IdentifyResult) -> Literal["translation", "motor_angle", "length", "torque"]:
    """Return the first measure that the fit has an error in."""
    known = {name for name, value in identified.rms.items() if value is not None}
    for name in MEASURES:
        if name in known:
            return name
    return "translation"


def _places_of(missing: Sequence[ProposedEffect], robot: CompliantRobot) -> tuple[list[int], list[int], list[str]]:
    """Return the joints, the links (by the joint that moves them) and the names of what a model still lacks."""
    joints: set[int] = set()
    links: set[int] = set()
    moved_by = robot.chain.joint_of_link
    names, present = [], names_in(robot)
    for entry in missing:
        name = f"{entry.effect} {place_words(entry.where)}"
        if name in present:  # added since it was diagnosed
            continue
        names.append(name)
        joints |= {*(entry.where.joints or ()), *(joint for pair in entry.where.pairs or () for joint in pair)}
        links |= {moved_by[name] for name in entry.where.links or () if name in moved_by}
    return sorted(joints), sorted(links), names


def _with_states(
    content: ViewContent,
    data: Ingested,
    identified: IdentifyResult,
    diagnosis: DiagnoseResult | None,
    reason: str,
    pick: Integers | None,
) -> ViewContent:
    raw = content.raw
    states, drawn = data.states, report_states_of(data)
    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    torque = torques_about_joints(states, robot)
    variables = _variables(data, drawn, torque, content.measure == "motor_angle")
    moved = moved_torque(robot, states, torque)
    if np.isfinite(moved).any() and torque.shape[1] > 1:
        variables.insert(
            0, ViewVariable(name="moved_torque", label="torque on the moved joint", unit="N·m", values=moved)
        )
    measured, own = drawn.measured, None
    if content.measure == "motor_angle":
        measured, own = motor_states(robot, states)
        label = "rotation of the moved motor"
        variables.insert(0, ViewVariable(name="motor", label=label, unit="°", values=DEGREES * measured[:, 0]))
    tables = tables_of_states(data, measured.shape[1], own is not None)
    last = LastAdded.of(data, identified)
    evidence, followed = view_evidence(
        data, diagnosis or diagnosis_of_states(data), variables, last.names, names_in(robot), diagnosis is not None
    )
    variables += followed
    evidence = [one for one in evidence if drawn.has_rotation or not one.turns] if own is None else []
    models = last.remarked(view_models(data, identified, variables, drawn.used, tables, own, evidence))
    variables += _rod_residuals(data)  # no candidates for what a residual follows: they are residuals themselves
    if pick is None:
        pick = sample_of(drawn.residual if own is None else own)
    shown = data.states.select(pick)
    nothing = np.zeros((len(pick), 0))
    moves, target = _shape(robot, shown) if own is None else (nothing, nothing)
    runs, lines, line_number = content.runs, [""] * len(pick), np.zeros(len(pick), dtype=np.int64)
    rows = np.zeros((len(states), 2), dtype=np.int64)
    if raw:
        spans = spans_of_sweeps(states.run, np.where(np.isfinite(moved), states.time, np.nan))
        runs, rows = rows_of_logs(data, runs, states.run, spans)
        of_table = np.array([bool(run.source) and not run.is_sampled for run in runs])[states.run]
        rows[of_table] = states.row[of_table, np.newaxis]
        runs, lines, line_number = with_raw_rows(data, runs, states.run[pick], rows[pick].sum(axis=1) // 2)
    missing = [model for model in models if model.kind in ("with", "all")]
    return replace(
        content,
        direction="direction" if any(variable.name == "direction" for variable in variables) else "branch",
        runs=runs,
        rotation=drawn.has_rotation,
        one_direction=drawn.along is not None,
        states=ViewStates(
            index=pick,
            run=states.run[pick],
            row=states.row[pick],
            first_row=rows[pick, 0],
            last_row=rows[pick, 1],
            used=drawn.used[pick],
            why=[str(text) for text in states.set_aside[pick]],
            lines=lines,
            line_number=line_number,
            measured=measured[pick],
            force=drawn.force[pick],
            shape=moves[..., :3],
            target=target,
            turns=moves[:, :-1, 3:] if content.bodies else np.zeros((0, 0, 3)),
        ),
        variables=[replace(variable, values=variable.values[pick]) for variable in variables],
        models=[picked_model(model, pick) for model in models],
        effects=view_effects(robot, states, pick, measured.shape[1]),
        evidence=[picked_evidence(one, pick) for one in evidence],
        change=last.change(models, evidence),
        readings=_readings(data.table, pick) if raw else {},
        refits_missing="" if missing else reason or "the store holds no refits: run stiffcal diagnose again",
    )


def _variables(data: Ingested, drawn: ReportStates, torque: Floats, clamped: bool) -> list[ViewVariable]:
    """Return what a residual may follow, over all states; a clamped robot's load has no direction of its own."""
    states, names = data.states, data.joint_names
    nowhere, slides = np.zeros(len(states)), data.campaign.chain.prismatic
    length, deflection = LENGTH.usual, np.linalg.norm(drawn.measured[:, :3], axis=1)
    moment = np.asarray(states.wrench[:, 3:])
    found = [
        *(
            ("torque", k + 1, f"{'force' if slides[k] else 'torque'} on joint {k + 1}", unit.name, unit.factor * column)
            for k, column in enumerate(torque.T)
            for unit in [(FORCE if slides[k] else MOMENT).usual]
        ),
        *(
            ("angle", k + 1, f"{'position' if slides[k] else 'angle'} of {names[k]}", unit.name, unit.factor * column)
            for k, column in enumerate(states.joints.T)
            for unit in [of_joint(bool(slides[k])).usual]
        ),
        ("load", 0, "load", "N", drawn.load),
        *(("force", k + 1, f"force along {'xyz'[k]}", "N", column) for k, column in enumerate(drawn.force.T)),
        *(
            ("moment", k + 1, f"moment about {'xyz'[k]} of the sensor", "N·m", column)
            for k, column in enumerate(moment.T)
        ),
        ("deflection", 0, "magnitude of the deflection", length.name, length.factor * deflection),
        ("time", 0, "time", "s", states.time),
        ("hold", 0, "time under load", "s", states.hold),
        *(("temperature", k + 1, f"temperature {k + 1}", "", column) for k, column in enumerate(states.temperature.T)),
        *(
            ("approach", k + 1, f"direction of the last motion of {names[k]}", "", np.where(column, column, np.nan))
            for k, column in enumerate(states.approach.T)
        ),
    ]
    # components are compared with the largest of their kind: what is left of products that cancel is no quantity
    sizes: dict[tuple[str, str], float] = {}
    for name, _, _, unit, values in found:
        sizes[name, unit] = max(
            sizes.get((name, unit), 0.0), float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        )
    variables = [
        ViewVariable(name=f"{name}{number or ''}", label=label, unit=unit, values=values)
        for name, number, label, unit, values in found
        if varies(values[np.isfinite(values)], sizes[name, unit])
    ]
    branch = nowhere + 2.0
    for number, word in enumerate(BRANCHES[:2]):
        branch[drawn.branch == word] = number
    if np.unique(branch).size > 1:
        variables.append(ViewVariable(name="branch", label="branch", unit="", values=branch, levels=BRANCHES))
    runs = [run.name for run in states.runs]
    variables.append(ViewVariable(name="run", label="run", unit="", values=states.run.astype(np.float64), levels=runs))
    labels = sorted(set(drawn.direction.tolist()))
    if len(labels) > 1 and not clamped:
        numbers = np.searchsorted(np.array(labels), drawn.direction).astype(np.float64)
        words = [label or "not loaded" for label in labels]
        variables.append(
            ViewVariable(name="direction", label="direction of the load", unit="", values=numbers, levels=words)
        )
    return variables


def _rod_residuals(data: Ingested) -> list[ViewVariable]:
    """Return what the present fit leaves of each rod's length, over all states."""
    names = [name for rods in data.states.setup.rods for name in rods.names]
    if not names or FIT_STATES not in data.store.tables:
        return []
    table, found = data.store.read_table(FIT_STATES), []
    for number, name in enumerate(names):
        column = f"{name}_length_m_residual"
        if column in table.column_names:
            values = np.full(len(data.states), np.nan)
            values[values_of(table.column("state"))] = LENGTH.usual.factor * values_of(table.column(column))
            label = f"residual of the present fit in the length of rod {name}"
            found.append(ViewVariable(name=f"rod{number + 1}", label=label, unit=LENGTH.usual.name, values=values))
    return found


def _shape(robot: CompliantRobot, states: LoadStates) -> tuple[Floats, Floats]:
    """Return how far base, joints and flange move under the load, and the measured point at rest (n, 3), m.

    The moves are (n, K, 6), m and rad, base axes.
    """
    chain: Chain = robot.chain
    bodies = tuple(Attachment(body, np.eye(4)) for body in range(chain.n_joints + 2))
    setup = replace(states.setup, targets=bodies, target_names=tuple(map(str, range(len(bodies)))))
    angles = chain.model_angles(states.joints)
    balance = solve_balance(robot, angles, np.nan_to_num(states.wrench), setup)
    target, _ = attached_poses(chain, angles, states.setup.targets[0])
    return balance.displacement, target


_ORDINARY = re.compile(r".*_scatter_|n_readings|.*_sigma_")


def _readings(table: pa.Table, pick: Integers) -> dict[str, Floats]:
    """Return the numbers that the store holds of the drawn states, by column; without those of scatter."""
    numbers = [
        entry.name for entry in table.schema if pa.types.is_floating(entry.type) and not _ORDINARY.match(entry.name)
    ]
    columns = {name: np.asarray(values_of(table.column(name)), dtype=np.float64)[pick] for name in numbers}
    return {name: values for name, values in columns.items() if np.isfinite(values).any()}
