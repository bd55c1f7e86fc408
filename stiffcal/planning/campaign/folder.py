"""A campaign folder made ready for the logs of a plan: its robot and model, and a run of campaign.toml for each run."""

from __future__ import annotations

import csv
import itertools
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.manifest.manifest_type import validate_manifest
from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.campaign.plan_file import PLAN_FILE, check_plan
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.toml_reading import parse_for_editing, toml_text
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell
from stiffcal.fault_codes import FaultCode
from stiffcal.files import holds_something
from stiffcal.log_columns import single_character

if TYPE_CHECKING:
    from tomlkit.items import AoT

    from stiffcal.campaign.loading import Campaign
    from stiffcal.planning.results import PlanResult

HEAD = """# A planned campaign: put the logs into raw/, under the names given below, then: stiffcal check
# A table that is filled in by hand begins with the header of raw/*_empty.csv.
# The run sheet is runs.pdf, as a table runs.csv; plan.toml is for further runs:  stiffcal plan
"""


def write_planned_campaign(folder: Path, campaign: Campaign, plan: PlanResult, force: float | None = None) -> list[str]:
    """Write the folder without its run sheets, and return its files.

    The sources, frames and thresholds are those of the campaign that the plan was made from; logs go to ``raw/``, a
    file per run and source: ``raw/run01_force.csv``. Sources whose one file serves all runs keep it, and absolute
    places keep their run: a row of its table for each pose. For a CSV table of load states ``raw/table_empty.csv`` has
    the header: filled in, it is saved as ``raw/table.csv``.

    Parameters
    ----------
    folder : to make; it must not exist, or be empty.
    campaign : what was planned for.
    plan : its runs.
    force : the largest force, N, where it is not that of plan.toml.

    Raises
    ------
    InputError : something lies in the folder already.
    """
    import tomlkit

    if folder.exists() and (not folder.is_dir() or holds_something(folder)):
        mend = "use a folder that does not exist yet"
        raise InputError.at(FaultCode.FILE_EXISTS, str(folder), "", "the folder is not empty", mend)
    manifest = _without_head(toml_text(campaign.folder / MANIFEST_FILE, MANIFEST_FILE))
    document = parse_for_editing(manifest, MANIFEST_FILE, validate_manifest)
    document.pop("exclude", None)
    if plan.experiment != "absolute":
        document.pop("runs", None)
        document["runs"] = _runs(campaign, plan)
    elif "runs" not in document:
        document["runs"] = tomlkit.aot()
        document["runs"].append(tomlkit.item({"id": "poses", "experiment": "absolute"}))
    (folder / "raw").mkdir(parents=True)
    (folder / MANIFEST_FILE).write_text(HEAD + tomlkit.dumps(document), encoding="utf-8", newline="\n")
    written = [MANIFEST_FILE]
    copied = [campaign.manifest.robot]
    copied += [MODEL_FILE] if campaign.model_written else []
    if campaign.robot.urdf is not None:
        copied.append(os.path.normpath(Path(campaign.manifest.robot).parent / campaign.robot.urdf))
    for name in copied:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(campaign.folder / name, folder / name)
        written.append(name)
    (folder / PLAN_FILE).write_text(_plan_text(campaign.folder, force), encoding="utf-8", newline="\n")
    written.append(PLAN_FILE)
    written += _empty_tables(folder, campaign)
    return written


def _empty_tables(folder: Path, campaign: Campaign) -> list[str]:
    """Write the header of every CSV table of load states that serves all runs; return the files.

    They are next to the tables under a name of their own: a table without rows is a fault, one that is not there yet is
    not. Tables with lines before the header, or in another encoding, are left to who writes them.
    """
    written = []
    for source in campaign.manifest.sources.values():
        file = source.file
        if file is None or not source.is_states or source.format_for(file) != "csv":
            continue
        options = source.options_of("csv")
        name = Path(file).with_stem(f"{Path(file).stem}_empty").as_posix()
        path = folder / name
        if options.keys() - {"delimiter", "decimal"} or not path.resolve().is_relative_to(folder.resolve()):
            continue
        comma = single_character(options, "decimal", MANIFEST_FILE) == ","
        delimiter = single_character(options, "delimiter", MANIFEST_FILE) or (";" if comma else ",")
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, delimiter=delimiter, lineterminator="\n")
            writer.writerow([csv_cell.escaped(name) for name in source.columns()])
        written.append(name)
    return written


def _without_head(text: str) -> str:
    """Return campaign.toml without the comment that it begins with, which is about the other campaign."""
    lines = text.splitlines(keepends=True)
    return "".join(itertools.dropwhile(lambda line: not line.strip() or line.lstrip().startswith("#"), lines))


def _plan_text(source: Path, force: float | None) -> str:
    """Return plan.toml for further runs: that of the plan's campaign, with the force that was given in its place."""
    import tomlkit

    file = source / PLAN_FILE
    text = toml_text(file, PLAN_FILE) if file.exists() else 'schema = "stiffcal/plan-input/1"\n'
    if force is None:
        return text
    document = parse_for_editing(text, PLAN_FILE, check_plan)
    document.setdefault("load", tomlkit.table())["force_N"] = force
    return tomlkit.dumps(document)


def _runs(campaign: Campaign, plan: PlanResult) -> AoT:
    """Return a run of campaign.toml for each run of the plan."""
    import tomlkit

    endings = _endings(campaign)
    runs = tomlkit.aot()
    for run in plan.runs:
        table = tomlkit.table()
        table["id"] = run.id
        table["experiment"] = plan.experiment
        if run.moved_joint is not None:
            table["moved_joint"] = run.moved_joint
        table["joints_deg"] = [round(float(angle), 2) for angle in np.degrees(run.joints)]
        if endings:
            files = tomlkit.inline_table()
            files.update({source: f"raw/{run.id}_{source}{ending}" for source, ending in endings.items()})
            table["files"] = files
        runs.append(table)
    return runs


def _endings(campaign: Campaign) -> dict[str, str]:
    """Return source to the ending of its files, of the sources that have a file in every run."""
    endings = {}
    for name, source in campaign.manifest.sources.items():
        if not source.in_files or source.file is not None or source.files:
            continue
        files = [run.files[name] for run in campaign.manifest.runs if name in run.files]
        endings[name] = Path(files[0]).suffix if files else ".csv"
    return endings
