"""Campaigns with a known truth, from a simulator that shares nothing with stiffcal; copies of them to break.

``01`` to ``12`` are those of ``campaigns/hidden``, tables of load states. ``13-raw`` holds raw logs of three poses with
the effect of ``02``, each device's clock from its own zero in every run; they lie compressed in ``data/practice-13``
and are written out where they are needed. ``13-table`` holds what a perfect reduction of these logs finds.
"""

from __future__ import annotations

import csv
import json
import lzma
import shutil
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.quality.data_quality import DataQuality
from stiffcal.ingest.reading import logs_of_runs
from stiffcal.ingest.reading.logs_of_runs import ReadingOptions
from stiffcal.ingest.reading.reducing import ReducedCampaign, collect_raw_states, reduce_campaign
from stiffcal.reduction.states.recordings import ReducedRun, reduce_run

HIDDEN = Path(__file__).resolve().parents[2] / "campaigns" / "hidden"
PRACTICE_13 = Path(__file__).parent / "data" / "practice-13"
NAMES = tuple(f"{number:02d}" for number in range(1, 13))


def copied(name: str, to: Path) -> Path:
    """Write a campaign to the folder ``to / name``, where a test may change it."""
    folder = to / name
    source = HIDDEN / name if name in NAMES else PRACTICE_13 / name
    for file in sorted(path for path in source.rglob("*") if path.is_file() and "store" not in path.parts):
        target = folder / file.relative_to(source)
        target.parent.mkdir(parents=True, exist_ok=True)
        if file.suffix == ".xz":
            target.with_suffix("").write_bytes(lzma.decompress(file.read_bytes()))
        else:
            shutil.copyfile(file, target)
    return folder


@cache
def _written_out() -> tempfile.TemporaryDirectory[str]:
    """Return a folder with 13-raw; it goes when the process ends."""
    place = tempfile.TemporaryDirectory(prefix="practice-", ignore_cleanup_errors=True)
    copied("13-raw", Path(place.name))
    return place


def folder_of(name: str) -> Path:
    """Return a campaign's folder, for reading only."""
    if name == "13-raw":
        return Path(_written_out().name) / name
    return HIDDEN / name if name in NAMES else PRACTICE_13 / name


@cache
def truth() -> dict[str, dict[str, Any]]:
    """Return what was hidden, by folder; both folders of 13 have the same entry."""
    files = (HIDDEN / "truth.json", PRACTICE_13 / "truth.json")
    entries = [entry for file in files for entry in json.loads(file.read_text("utf-8"))]
    return {name: entry for entry in entries for name in entry["folder"].split(" and ")}


@cache
def reduced(name: str) -> ReducedCampaign:
    """Return a campaign, reduced."""
    return reduce_campaign(load_campaign(folder_of(name)), no_progress)


@cache
def raw_runs() -> tuple[ReducedRun, ...]:
    """Return the reduced runs of 13-raw."""
    campaign = load_campaign(folder_of("13-raw"))
    runs: list[ReducedRun] = []

    def kept(*arguments: Any) -> ReducedRun:
        runs.append(reduce_run(*arguments))
        return runs[-1]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(logs_of_runs, "reduce_run", kept)
        collect_raw_states(campaign, no_progress, ReadingOptions(), DataQuality(campaign))
    return tuple(runs)


def true_holds(run: str) -> Floats:
    """Return (h, 2) start and end of the holds of 13-raw, s on the force log's clock."""
    with (folder_of("13-table") / "raw" / "states.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["run"] == run]
    return np.array([[float(row["start"]), float(row["end"])] for row in rows])


def first_run_alone(to: Path) -> Path:
    """Write 13-raw with its first run alone."""
    folder = copied("13-raw", to)
    text = (folder / "campaign.toml").read_text()
    second = text.index("[[runs]]", text.index("[[runs]]") + 1)
    (folder / "campaign.toml").write_text(text[:second])
    return folder


def edit(path: Path, *changes: tuple[str, str]) -> None:
    """Replace pieces of a file, each of which has to be there."""
    text = path.read_text(encoding="latin-1")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="latin-1")


def edit_table(folder: Path, change: Callable[[list[str], list[list[str]]], None]) -> None:
    """Change header and rows of the table of states."""
    path = folder / "raw" / "states.csv"
    lines = [line.split(",") for line in path.read_text().splitlines()]
    header, rows = lines[0], lines[1:]
    change(header, rows)
    path.write_text("\n".join(",".join(line) for line in [header, *rows]) + "\n")
