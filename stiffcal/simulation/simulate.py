"""Simulating a whole campaign: raw logs of a known robot, and the truth with them.

The manifest of the folder given states what is logged how; `simulate.toml` what is done and how instruments err; the
model file, every parameter with a value, what the robot is. The result is a campaign folder like any other. Its model
file has lost the values: its analysis starts as a laboratory's does, and only `truth.json` holds the true values.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from stiffcal.campaign.frames.gauges import metres_of_rods
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.file_patterns import ANY
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.model.model_file import MODEL_FILE, check_model
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import check_inside
from stiffcal.campaign.toml.toml_reading import parse_for_editing, toml_text
from stiffcal.documents import Document
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular, holds_something
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.simulation.extent import check_extent
from stiffcal.simulation.hidden import check_hidden
from stiffcal.simulation.kinds import run_simulation
from stiffcal.simulation.played.controller import compensated
from stiffcal.simulation.played.motion import MotionProgram
from stiffcal.simulation.played.true_motion import PlannedRun, RestSolver, TrueRun, solve_true_runs
from stiffcal.simulation.scene import draw_acts, robot_with_values, rods_on_links, tool_weight, true_frames
from stiffcal.simulation.settings import FILE_NAME, SimulationSettings, TrueRobot
from stiffcal.simulation.truth import TRUTH_FILE, truth_document
from stiffcal.simulation.written.logs import Column, check_format, dialect_of, write_log
from stiffcal.simulation.written.recording import Device, DeviceLog, RecordingContext, devices_of, record
from stiffcal.trust.output_kinds import CAMPAIGN_FILE, LOG, MODEL, TRUTH
from stiffcal.trust.outputs import check_copy, check_not_foreign, write_copy, write_output, written


def simulate_campaign(
    campaign: Campaign,
    settings: SimulationSettings,
    out: Path,
    seed: int | None = None,
    progress: Progress = no_progress,
    settle: RestSolver | None = None,
    *,
    overwrite: bool = False,
) -> Document:
    """Write a simulated campaign folder.

    Parameters
    ----------
    campaign : the folder given to ``--from``, loaded with ``check_files=False``.
    settings : its `simulate.toml`, of `load_settings`.
    out : the folder to write; may be the campaign's own (then only logs and truth are written).
    seed : for all that is drawn; None: the settings'. The same seed gives the same bytes.
    progress : receives what is being done.
    settle : another robot that is loaded in place of the model file's, e.g. a physics engine; the model file then only
        decides what the truth is called.
    overwrite : also files that hold something stiffcal did not write.

    Returns
    -------
    dict
        ``folder``, ``files`` (relative), ``seed``, ``runs``, ``states``, ``truth`` (the document of truth.json).

    Raises
    ------
    InputError
        a parameter lacks a value, folder, settings and manifest do not go together, or a file to write holds
        something else.
    """
    out = Path(out)
    drawn = settings.seed if seed is None else seed
    if drawn < 0:
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--seed", f"{drawn} is negative", "give a whole number from 0"
        )
    if not overwrite:
        _check_out(out, campaign.folder)
    _check_goals(out, campaign, (), overwrite=overwrite)
    progress("setting loads", 0.0)
    robot, recording = simulate_runs(campaign, settings, drawn, settle)
    devices_by_run = [
        devices_of(
            recording, campaign.manifest.sources, run, partial(_logs_run, campaign.manifest, true_run.planned.name)
        )
        for run, true_run in enumerate(recording.true_run)
    ]
    logs: list[list[DeviceLog]] = []
    for number, devices in enumerate(devices_by_run):
        progress(f"recording {recording.true_run[number].planned.name}", 0.1 + 0.5 * number / len(devices_by_run))
        logs.append([record(recording, device) for device in devices])
    corrects = any(run.compensation == "on" for run in campaign.manifest.runs)
    truth = truth_document(robot, recording, devices_by_run, logs, settings.controller if corrects else None)
    planned = _log_files(campaign, devices_by_run, logs)
    _check_goals(out, campaign, [log.name for log in planned], overwrite=overwrite)
    with _only_whole(out):
        # First: it distinguishes a folder that a killed process left half-made from one that holds something else.
        write_output(out / TRUTH_FILE, json.dumps(truth, indent=1) + "\n", TRUTH, overwrite)
        for number, log in enumerate(planned):
            progress(f"writing {log.name}", 0.6 + 0.4 * number / len(planned))
            _write_file(out / log.name, log, overwrite=overwrite)
        files = [*(log.name for log in planned), TRUTH_FILE]
        if out.resolve() != campaign.folder.resolve():
            files += _copy_documents(campaign, out, settings.robot.hidden, overwrite=overwrite)
    progress("simulated", 1.0)
    states = sum(len(true_run.planned.program) for true_run in recording.true_run)
    runs = [true_run.planned.name for true_run in recording.true_run]
    return {"folder": str(out), "files": files, "seed": drawn, "runs": runs, "states": states, "truth": truth}


def simulate_runs(
    campaign: Campaign, settings: SimulationSettings, seed: int, settle: RestSolver | None = None
) -> tuple[CompliantRobot, RecordingContext]:
    """Draw the load cycles and find where the robot (``settle``, or the model file's) really is, without instruments.

    Raises
    ------
    InputError
        as `simulate_campaign`.
    """
    check_extent(settings, campaign.manifest)
    robot = robot_with_values(campaign, settings.robot, seed)
    absent = [
        name
        for name in settings.robot.hidden
        if name not in {placed_effect.effect.name for placed_effect in robot.placed}
    ]
    if absent:
        raise InputError.at(
            FaultCode.EFFECT_ABSENT,
            FILE_NAME,
            "robot.hidden",
            f"the model file contains no {absent[0]}",
            f"it contains: {', '.join(sorted({placed_effect.effect.name for placed_effect in robot.placed}))}",
        )
    frames = true_frames(campaign, settings)
    for name in settings.sensors:
        if name not in campaign.manifest.sources:
            known_names = ", ".join(campaign.manifest.sources)
            raise InputError.at(
                FaultCode.SOURCE_UNKNOWN,
                FILE_NAME,
                f"sensors.{name}",
                "campaign.toml has no such source",
                f"use one of {known_names}",
            )
    planned_runs = [
        _with_temperature(planned, campaign.manifest, settings.robot)
        for planned in draw_acts(campaign, settings, frames, seed)
    ]
    solve = partial(_true_runs, campaign.manifest, settings, frames, planned_runs)
    runs, rods = solve(robot, settle), rods_on_links(campaign)
    if settle is None:
        check_hidden(settings.robot.hidden, robot, runs, solve)
    return robot, RecordingContext(
        settings, frames, runs, seed, campaign.chain.gear_ratio, rods, metres_of_rods(campaign.manifest)
    )


def _true_runs(
    manifest: Manifest,
    settings: SimulationSettings,
    frames: Mapping[str, Attachment],
    planned_runs: Sequence[PlannedRun],
    robot: CompliantRobot,
    settle: RestSolver | None = None,
) -> tuple[TrueRun, ...]:
    """Return where a robot really is in all runs, in their order."""
    tool = tool_weight(manifest)
    load_runs = [planned for planned in planned_runs if not isinstance(planned.program, MotionProgram)]
    true_run = {solved.planned.name: solved for solved in solve_true_runs(robot, load_runs, frames, tool, settle)}
    on = {run.id for run in manifest.runs if run.compensation == "on"}
    correcting = [solved for name, solved in true_run.items() if name in on]
    for compensated_run in compensated(robot, correcting, settings.controller, frames, tool, settle):
        true_run[compensated_run.planned.name] = compensated_run
    kinds = {run.id: run.experiment for run in manifest.runs}
    for planned, run in zip(planned_runs, settings.runs, strict=True):
        kind = kinds.get(run.id, "load")
        simulation = run_simulation(kind)
        if simulation is not None:
            motion = settings.motion_of(kind, run)
            true_run[planned.name] = simulation.true_run(robot, planned, frames, tool, motion)
    return tuple(true_run[planned.name] for planned in planned_runs)


def _with_temperature(planned: PlannedRun, manifest: Manifest, robot: TrueRobot) -> PlannedRun:
    """Return a run with how everything warms up, and the temperature that effects know: where one is logged."""
    logged = any(
        source.temperature is not None and _logs_run(manifest, planned.name, name)
        for name, source in manifest.sources.items()
    )
    start = 273.15 + robot.temperature_C if logged else np.nan
    return replace(planned, warming_K_per_hour=robot.warming_K_per_hour, start_K=start)


def _logs_run(manifest: Manifest, run: str, source: str) -> bool:
    """Return whether a source logs a run: it has a file of its own, or for this run, or for none that is listed."""
    runs = [entry for entry in manifest.runs if source in entry.files]
    return not runs or any(entry.id == run for entry in runs)


def _check_out(out: Path, source: Path) -> None:
    """Raise where the folder to write holds something that no simulation has made."""
    if out.resolve() == source.resolve() or not out.exists():
        return
    if not out.is_dir():
        raise InputError.at(FaultCode.FILE_KIND, str(out), "", "this is a file", "use a folder that does not exist yet")
    if holds_something(out) and not (out / TRUTH_FILE).exists():
        raise InputError.at(
            FaultCode.FILE_EXISTS, str(out), "", "the folder is not empty", "use a folder that does not exist yet"
        )


def _check_goals(out: Path, campaign: Campaign, logs: Sequence[str], *, overwrite: bool) -> None:
    """Raise where a file to write is there already and is neither a simulation's nor what it will be."""
    for name, kind in ((TRUTH_FILE, TRUTH), *((log, LOG) for log in logs)):
        check_inside(out, name)
        check_not_foreign(out / name, kind, overwrite)
    if out.resolve() != campaign.folder.resolve():
        for name in _document_names(campaign):
            check_inside(out, name)
            check_copy(campaign.folder / name, out / name, CAMPAIGN_FILE, overwrite)
        if campaign.model_written:
            check_not_foreign(out / MODEL_FILE, MODEL, overwrite)


@contextmanager
def _only_whole(out: Path) -> Iterator[None]:
    """Make the folder; take away what was written into an empty one where not all of it can be."""
    exists = out.exists()
    empty = not exists or not holds_something(out)
    out.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        if empty:
            with suppress(OSError):
                for path in out.iterdir():
                    shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)
                if not exists:
                    out.rmdir()
        raise


@dataclass(frozen=True)
class _LogFile:
    """A log to write."""

    name: str
    """Relative to the folder, as the manifest has it."""
    source: Source
    """What it is a log of."""
    device: Device
    """What writes it."""
    parts: tuple[DeviceLog, ...]
    """Of one run, or of all runs one after the other."""


def _log_files(
    campaign: Campaign, devices_by_run: Sequence[Sequence[Device]], logs: Sequence[Sequence[DeviceLog]]
) -> list[_LogFile]:
    """Return every source's files as the manifest names them."""
    manifest = campaign.manifest
    runs = {run.id: run for run in manifest.runs}
    files = []
    for name, source in manifest.sources.items():
        by_file: dict[str, list[DeviceLog]] = {}
        members = [
            (device, log)
            for devices, written in zip(devices_by_run, logs, strict=True)
            for device, log in zip(devices, written, strict=True)
            if device.name == name
        ]
        for device, log in members:
            run = runs.get(device.run_name)
            if run is None and source.pattern is not None:
                named = {"": source.pattern.file_of(device.run_name).replace(ANY, "simulated")}
            else:
                named = manifest.files_of(name, run)
            if list(named) != [""]:
                raise InputError.at(
                    FaultCode.SIMULATION_UNSUPPORTED,
                    MANIFEST_FILE,
                    f"sources.{name}",
                    "a simulated source writes only one file",
                    "give one file for it",
                )
            by_file.setdefault(named[""], []).append(log)
        files += [_LogFile(file, source, members[0][0], tuple(parts)) for file, parts in by_file.items()]
    return files


def _write_file(path: Path, log: _LogFile, *, overwrite: bool) -> None:
    source, device, parts = log.source, log.device, log.parts
    columns: dict[str, Column] = {}
    for name, first in parts[0].columns.items():
        pieces = [table.columns[name] for table in parts]
        if isinstance(first, np.ndarray):
            columns[name] = np.concatenate([np.asarray(piece) for piece in pieces])
        else:
            columns[name] = [word for piece in pieces for word in piece]
    dialect = dialect_of(source, device.sensor.preamble, parts[0].decimals, parts[0].units, f"sensors.{device.name}")
    group = str(source.options_of("hdf5").get("group") or "/")
    log_format = source.format_for(log.name) or "csv"
    check_format(log_format, path.name)
    path.parent.mkdir(parents=True, exist_ok=True)
    with written(path, LOG, overwrite) as temporary:
        write_log(temporary, log_format, columns, dialect, group)


def _document_names(campaign: Campaign) -> list[str]:
    """Return what is copied as it is, the manifest last: without it a half-made folder is no campaign yet."""
    names = [campaign.manifest.robot, *campaign.manifest.plugins]
    if campaign.robot.urdf is not None:
        names.append(str(Path(campaign.manifest.robot).parent / campaign.robot.urdf))
    return [*(Path(name).as_posix() for name in names), MANIFEST_FILE]


def _copy_documents(campaign: Campaign, out: Path, hidden: Sequence[str], *, overwrite: bool) -> list[str]:
    """Copy manifest, robot and plugins as they are, and the model file without its values and hidden effects."""
    names = _document_names(campaign)
    content = toml_text(campaign.model_path, MODEL_FILE) if campaign.model_written else None
    if content is not None:
        write_output(out / MODEL_FILE, without_values(content, hidden), MODEL, overwrite)
    for name in names:
        check_inside(out, name)
        check_regular(campaign.folder / name, name)
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        write_copy(campaign.folder / name, out / name, CAMPAIGN_FILE, overwrite)
    return [Path(name).as_posix() for name in (*names, *([MODEL_FILE] if content is not None else []))]


def without_values(model: str, hidden: Sequence[str] = ()) -> str:
    r"""Return a model file's text without its parameters' values and without some effects, comments kept.

    Examples
    --------
    >>> text = 'schema = "stiffcal/model/1"\n[[effects]]\ntype = "creep"\njoints = [2]\n'
    >>> text += '[effects.parameters]\n"creep.j2.c" = { value = 1e-8 }\n'
    >>> print(without_values(text).strip())
    schema = "stiffcal/model/1"
    [[effects]]
    type = "creep"
    joints = [2]
    """
    document = parse_for_editing(model, MODEL_FILE, check_model)
    effects: Any = document.get("effects", [])
    for index in reversed(range(len(effects))):
        if effects[index]["type"] in hidden:
            del effects[index]
        else:
            effects[index].pop("parameters", None)
    return tomlkit.dumps(document)
