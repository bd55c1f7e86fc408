"""From what lies in the store to what the report and the plots show."""

from __future__ import annotations

import hashlib
import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.found.experiment_kinds import measure_of
from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.campaign.signals.signals import JointSignals, Wrench
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.compensation.predict_result import LoadPath
from stiffcal.documents import Document, result_of
from stiffcal.files import read_regular
from stiffcal.identification.readings.state_loads import torques_about_joints
from stiffcal.ingest.parts import PROVENANCE
from stiffcal.ingest.reading.recording_tables import recording_name
from stiffcal.kinds import all_kinds
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.summary import EffectAt
from stiffcal.quantity import FORCE, MOMENT, unit_words
from stiffcal.report.content import ReportContent, ReportRun, ReportStates, ResidualCovariate, SetAsideRows
from stiffcal.report.gathering.bodies import joint_pictures
from stiffcal.report.gathering.compensation import with_and_without
from stiffcal.report.gathering.diagnosis import with_diagnosis
from stiffcal.report.gathering.fit_changes import fit_changes
from stiffcal.report.gathering.links import link_pictures
from stiffcal.report.gathering.shares import place_shares
from stiffcal.report.gathering.states import report_states_of
from stiffcal.report.provenance_content import ReportInstrument, ReportProvenance, ReportSource
from stiffcal.results.history_results import HistoryResult
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.stages.diagnoses.current import current_diagnosis
from stiffcal.stages.experiments import runs_with_fits
from stiffcal.stages.steps import LOAD_PATHS, Ingested, stored_document, stored_ingest
from stiffcal.store import Provenance, SourceFile
from stiffcal.store.document_shape import result_from
from stiffcal.store.index import FOREIGN

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.mechanics.chain import Chain


MOST_COVARIATES = 3
# A share of the largest torque: what double precision leaves of none.
ROUNDING = 1e-9
JOINT_MEASURES = {
    "position": "joint angles",
    "command": "commanded angles",
    "velocity": "joint velocities",
    "torque": "torques of the drives",
    "current": "currents of the drives",
}
MEASURES = {
    "wrench": "force and moment",
    "pose": "pose",
    "joints": "joint angles",
    "lengths": "rod lengths",
    "displacement": "displacement along one direction",
    "deflection": "deflection",
    "temperature": "temperature",
    "hold": "time under load",
    "dead_weight": "dead weight",
}


def report_content(
    data: Ingested, identified: IdentifyResult, validation: ValidateResult, history: HistoryResult
) -> ReportContent:
    """Gather everything that a report shows.

    Parameters
    ----------
    data : the campaign with its states.
    identified : the present fit. validation : of it. history : every fit.
    """
    states, chain = data.states, data.campaign.chain
    # Of clamped runs alone no displacement was measured: their own pages show them.
    report_states = report_states_of(data) if states.has_poses or np.isfinite(states.displacement).any() else None
    paths = stored_document(data.store, LOAD_PATHS) or {"paths": []}
    other_runs = tuple(
        ReportRun(
            run.id, np.full(len(data.joint_names), np.nan), holdout=run.holdout, tags=run.tags, kind=run.experiment
        )
        for run in data.campaign.manifest.runs
        # Rows of absolute runs are runs of their own.
        if measure_of(run.experiment) is not StateMeasure.PLACE and run.id not in {info.name for info in states.runs}
    )
    diagnosis, _ = current_diagnosis(data, identified)
    named = (
        () if diagnosis is None else tuple(EffectAt(effect=one.effect, where=one.where) for one in diagnosis.missing)
    )
    measured = replace(runs_with_fits(data), missing=named)
    drawn_pages = [kind.page(measured, identified) for kind in all_kinds()]
    pages = tuple(page for page in drawn_pages if page is not None)
    main_tables = [table for kind in all_kinds() if (table := kind.main_table(identified)) is not None]
    unused = [SetAsideRows(entry.run, entry.numbers, entry.why) for page in pages for entry in page.unused]
    content = ReportContent(
        provenance=_provenance(data, identified, history),
        runs=_runs(states, chain) + other_runs,
        joint_names=data.joint_names,
        prismatic_joints=chain.prismatic_joints,
        states=report_states,
        identify=identified,
        validate=validation,
        history=history,
        place_shares=() if report_states is None else place_shares(data, identified),
        fit_changes=fit_changes(data),
        ingest=stored_ingest(data.store),
        instruments=tuple(_instruments(data)),
        set_aside=(*_set_aside(states), *unused),
        covariates=() if report_states is None else tuple(most_correlated_covariates(data, identified, report_states)),
        load_paths=tuple(_load_path(path) for path in paths["paths"]),
        pages=pages,
        main_tables=tuple(main_tables),
        joint_pictures=joint_pictures(data, identified),
        link_pictures=link_pictures(data, identified),
        with_and_without=with_and_without(data),
        settings=data.campaign.manifest.report,
    )
    return with_diagnosis(content, data, identified)


def _runs(states: LoadStates, chain: Chain) -> tuple[ReportRun, ...]:
    rows = []
    for info, members in zip(states.runs, states.members(), strict=True):
        if not members.size:
            # States count runs by number: a run of which nothing is left keeps its place.
            rows.append(
                ReportRun(
                    info.name,
                    np.full(states.joints.shape[1], np.nan),
                    holdout=info.holdout,
                    kind=info.experiment,
                    measures=info.measures,
                )
            )
            continue
        joints = np.mean(states.joints[members], axis=0)
        angles = chain.model_angles(joints[None])
        stick, _ = body_poses(chain, angles)
        target, _ = attached_poses(chain, angles, states.setup.targets[0])
        has_extent = float(np.ptp(stick[0], axis=0).max()) > 0.0  # a joint on a bench has none: nothing to draw
        figure, end = (stick[0], target[0]) if has_extent else (None, None)
        rows.append(ReportRun(info.name, joints, figure, end, info.holdout, info.tags, info.experiment, info.measures))
    return tuple(rows)


def _provenance(data: Ingested, identified: IdentifyResult, history: HistoryResult) -> ReportProvenance:
    document = data.store.read_document(PROVENANCE)
    stored = result_from(Provenance, document, data.store.display_name, PROVENANCE)
    campaign, versions = data.campaign, dict(stored.versions)
    ours = ("stiffcal", versions.pop("stiffcal"))
    time = next((fit.time for fit in history.fits if fit.id == identified.fit_id), stored.created)
    loss = {"linear": "least squares", "huber": "Huber loss"}[identified.loss]
    scaled = identified.std_scaled_by_reduced_chi2
    return ReportProvenance(
        campaign=campaign.name,
        robot=campaign.robot.name or campaign.chain.name or "robot",
        date=time[:10],
        versions=(ours, *sorted(versions.items())),
        sources=_sources(data, stored.sources),
        settings=(
            ("balance", "on the deformed robot" if campaign.model.balance == "deformed" else "first order"),
            ("loss", loss),
            ("noise from", identified.noise_source),
            ("standard uncertainties", "scaled by reduced χ²" if scaled else "from the noise"),
            ("fit", identified.fit_id),
        ),
    )


def _sources(data: Ingested, read: Sequence[SourceFile]) -> tuple[ReportSource, ...]:
    """Return the logs as they were read, and the campaign's own files and the user's effects as they stand."""
    read_files = {source.file for source in read}
    folder = data.campaign.folder
    manifest = data.campaign.manifest
    campaign_files = [MANIFEST_FILE, manifest.robot, MODEL_FILE, *manifest.plugins]
    entries = []
    for name in dict.fromkeys(campaign_files):
        if name not in read_files and (folder / name).is_file():
            content = read_regular(folder / name, name)
            entries.append(ReportSource(name, hashlib.sha256(content).hexdigest(), len(content)))
    return (*entries, *(ReportSource(source.file, source.sha256, source.bytes) for source in read))


def _instruments(data: Ingested) -> list[ReportInstrument]:
    instruments = []
    for source, name, signal in data.campaign.manifest.signals():
        kind = name.split(".")[0]
        entry = data.campaign.manifest.sources[source]
        if isinstance(signal, JointSignals):
            kind = ", ".join(JOINT_MEASURES[key] for key in signal.groups())
        measures = MEASURES.get(kind.removesuffix("s") if kind == "poses" else kind, kind)
        if isinstance(signal, Wrench) and not signal.moments_measured:
            measures = "force" if len(signal.columns) == 3 else "force along one direction"
        body = getattr(signal, "body", None)
        detail = [str(entry.format or "csv")]
        frame = getattr(signal, "frame", None) or getattr(signal, "axes", None)
        if frame:
            detail.append(f"frame {frame}")
        instruments.append(
            ReportInstrument(
                source=source,
                measures=f"{measures} of {body}" if body else measures,
                detail=", ".join(detail),
                rate=None if entry.is_states else _rate(data, source),
                sigma=_sigma_in_words(signal),
            )
        )
    return instruments


def _rate(data: Ingested, source: str) -> float | None:
    """Return samples per second of a source's first recording."""
    for name in data.store.tables:
        if name.startswith("recordings/") and name.endswith(recording_name("", source).removeprefix("recordings/")):
            time = values_of(data.store.read_table(name, columns=["time_s"]).column("time_s"))
            span = float(time[-1] - time[0]) if len(time) > 1 else 0.0
            return (len(time) - 1) / span if span > 0.0 else None
    return None


def _sigma_in_words(signal: Any) -> str:
    sigma = getattr(signal, "sigma", None)
    if sigma is None:
        return ""
    units = getattr(signal, "units", None)
    texts = []
    for quantity, value in sigma.model_dump(exclude_none=True).items():
        if quantity == "per_metre":
            texts.append(f"plus {value:g} {unit_words(getattr(units, 'position', ''))} per m of distance")
            continue
        unit = getattr(units, quantity, None) or {"rotation": "rad", "force": "N", "moment": "N·m"}.get(quantity, "")
        if quantity == "coverage" and value == 1.0:
            continue
        stated = f"{value:g} {unit_words(unit)}" if isinstance(value, float) else "by row"
        texts.append(f"{quantity} {stated}".strip())
    return ", ".join(texts)


_OF_ONE_STATE = (SetAsideCode.BUMPED, SetAsideCode.HELD_BRIEFLY)
"""Causes whose texts hold figures of the state itself."""


def _set_aside(states: LoadStates) -> list[SetAsideRows]:
    """Return the states of each run that are not used, those of one cause in one entry; `_OF_ONE_STATE` each alone."""
    groups: dict[tuple[str, SetAsideCode, str], list[int]] = defaultdict(list)
    for i in np.flatnonzero(~states.used).tolist():
        code = SetAsideCode(states.set_aside_code[i])
        # an exclusion's text is the manifest's reason for it, one entry for each
        detail = str(states.set_aside[i]) if code == SetAsideCode.EXCLUDED else str(i) if code in _OF_ONE_STATE else ""
        groups[states.runs[states.run[i]].name, code, detail].append(i)
    return [
        SetAsideRows(run, tuple(states.row[members].tolist()), str(states.set_aside[members[0]]))
        for (run, _, _), members in groups.items()
    ]


def joint_torques(data: Ingested, identified: IdentifyResult) -> Floats:
    """Return (n, J) N·m: the whole torque about each joint's axis, weight included, at the fitted balance."""
    return torques_about_joints(data.states, placed_robot(data.campaign).with_values(identified.robot_values()))


def most_correlated_covariates(
    data: Ingested, identified: IdentifyResult, states: ReportStates
) -> list[ResidualCovariate]:
    """Return the joint torques that the residual follows most, strongest first."""
    torque = joint_torques(data, identified)
    residual = states.residual[:, :3]
    keep = states.used & np.isfinite(residual).all(axis=1)
    if np.count_nonzero(keep) < 3:
        return []
    strength = []
    # what is left of a torque on an axis that no weight turns is rounding
    least = ROUNDING * float(np.max(np.abs(torque[keep])))
    for joint in range(torque.shape[1]):
        values = torque[keep, joint]
        spread = np.std(values)
        if spread <= least:
            strength.append(0.0)
            continue
        slope = (values - values.mean()) @ (residual[keep] - residual[keep].mean(axis=0)) / (len(values) * spread)
        strength.append(float(np.linalg.norm(slope)))
    ranked = np.argsort(-np.array(strength), kind="stable")[:MOST_COVARIATES]
    slides = data.campaign.chain.prismatic
    return [
        ResidualCovariate(
            f"{'force' if slides[joint] else 'torque'} on joint {joint + 1}",
            (FORCE if slides[joint] else MOMENT).usual.name,
            torque[:, joint],
        )
        for joint in ranked
        if strength[joint] > 0.0
    ]


def _load_path(entry: Document) -> LoadPath:
    path = result_of(LoadPath, json.dumps(entry))
    return replace(path, pose=path.pose + ("; not computed by you" if path.origin == FOREIGN else ""))
