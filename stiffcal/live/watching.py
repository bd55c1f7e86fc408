"""Logs that are followed while they are measured: what `check` says of each run, and which runs the page shows."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Literal

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_loaded
from stiffcal.ingest.ingesting import ingest_now
from stiffcal.kinds.declared_tables import campaign_store
from stiffcal.live.log_files import Log, LogFiles, Stage
from stiffcal.stages.steps import with_runs

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.live.models import LiveModels

MOST_LINES = 3
"""Of a run that the panel shows: one wrong header has a fault for each of its columns."""
LOOK_S = 0.5
"""Between two looks: half of what makes a log settled."""
TEXT = "csv"
"""The format whose files consist of lines."""


@dataclass(frozen=True, kw_only=True)
class WatchedRun:
    """A run as the panel shows it."""

    id: str
    """Its name; "" of tables that hold several."""
    stage: Literal["waiting", "read", "faulty"]
    """"waiting" for a log or for the rest of one, "read", or "faulty": its lines say why."""
    n_states: int | None = None
    """Load states that are used; None where it is not read."""
    n_readings: int | None = None
    """Readings of a run without load states."""
    lines: list[str] = field(default_factory=list)
    """What `check` says of it, or what it waits for."""


@dataclass(frozen=True, kw_only=True)
class WatchedLogs:
    """What is known of the logs after a look."""

    version: int = 0
    """Raised whenever the page has other readings to show; 0: none yet."""
    runs: list[WatchedRun] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    """What concerns the whole campaign."""


@dataclass(frozen=True)
class _Checked:
    """What `check` said of a run's logs as they were."""

    stamp: object
    n_states: int | None = None
    n_readings: int | None = None
    lines: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()


class LogWatcher:
    """Follows the logs of a campaign, and has the page's models take what has come.

    Parameters
    ----------
    folder : of the campaign. models : of the page. files : how far each log is.
    """

    def __init__(self, folder: Path, models: LiveModels, files: LogFiles | None = None) -> None:
        self._folder, self._models = folder, models
        self._files = files or LogFiles(folder)
        self._checked: dict[str, _Checked] = {}
        self._taken: dict[str, object] = {}
        self._serial = 0
        self._lines: list[str] = []
        self._place = tempfile.TemporaryDirectory(prefix="stiffcal-")
        self._stop = Event()
        self.seen = WatchedLogs()
        """After the last look; taken whole by other threads."""

    def run(self) -> None:
        """Look until `stop` is called."""
        while not self._stop.is_set():
            self.look()
            self._stop.wait(LOOK_S)

    def stop(self) -> None:
        """End `run`."""
        self._stop.set()

    def close(self) -> None:
        """Remove what was read; nobody may look any more."""
        self._place.cleanup()

    def look(self) -> None:
        """Look at the logs once; read those that have settled."""
        try:
            campaign = load_campaign(self._folder, check_files=False)
        except InputError as error:
            self.seen = replace(self.seen, lines=list(map(str, error.faults)))
            return
        needed, shared = _files_of(campaign)
        logs = self._files.look({*(file for own in needed.values() for file in own), *shared})
        shared_logs = {file: logs[file] for file, _ in shared}
        ready = {}
        for run, own in needed.items():
            logs_of_run = {file: logs[file] for file, _ in own} | shared_logs
            if all(log.is_readable for log in logs_of_run.values()):
                ready[run] = logs_of_run
        for run, logs_of_run in ready.items():
            stamp = (_stamp_of(campaign), tuple((file, log.stamp) for file, log in logs_of_run.items()))
            known = self._checked.get(run)
            if known is None or known.stamp != stamp:
                self._checked[run] = _check(_kept(campaign, needed, {run}), run, stamp)
        good = {run: self._checked[run].stamp for run in ready if not self._checked[run].faults}
        # a run of which more is being written stays as it was read
        growing = {
            run
            for run, own in needed.items()
            if run not in ready and all(logs[file].stage is not Stage.ABSENT for file, _ in own)
        }
        is_other = bool(self._taken.keys() - good.keys() - growing) or any(
            self._taken.get(run) != stamp for run, stamp in good.items()
        )
        lines = self._take(campaign, needed, good) if good and is_other else self._lines
        runs = [self._shown(run, {file: logs[file] for file, _ in own} | shared_logs) for run, own in needed.items()]
        self.seen = WatchedLogs(version=self._serial, runs=[*runs, *_without_partner(campaign)], lines=lines)

    def _take(self, campaign: Campaign, needed: Collection[str], good: Mapping[str, object]) -> list[str]:
        """Have the models take the runs that are right; return what is to be said of all of them.

        Parameters
        ----------
        needed : the runs with logs of their own. good : what their logs were when they were checked, by run.
        """
        kept = _kept(campaign, needed, good)
        self._taken = dict(good)
        store = Path(self._place.name) / f"store{self._serial + 1}"
        before = store.with_name(f"store{self._serial}")
        if before.exists() and not store.exists():
            _begin_from(before, store)
        place = campaign_store(store, display_name="the logs that have come")
        try:
            ingest_now(kept, place, "")
            self._models.take_runs(frozenset(run.id for run in kept.manifest.runs), str(store))
            shutil.rmtree(before, ignore_errors=True)
            self._serial += 1
            checked = check_loaded(kept, store=place)
        except InputError as error:
            if any(fault.code is FaultCode.FILE_CHANGED for fault in error.faults):
                self._taken = {}  # somebody went on writing: at the next look
            self._lines = list(map(str, error.faults))
        else:
            self._lines = [*checked.warnings, *checked.missing]
        return self._lines

    def _shown(self, run: str, logs: Mapping[str, Log]) -> WatchedRun:
        """Return a run as the panel shows it; what is wrong with it only once nobody writes its logs."""
        waits = [f"{file}: {log.stage.value}" for file, log in logs.items() if not log.is_readable]
        checked = self._checked.get(run)
        if waits or checked is None:
            return WatchedRun(id=run, stage="waiting", lines=waits)
        if not checked.faults:
            # what is said of all runs together stands above them, once
            own = [line for line in checked.lines if line not in self._lines]
            return WatchedRun(
                id=run, stage="read", n_states=checked.n_states, n_readings=checked.n_readings, lines=_shortened(own)
            )
        unfinished = [f"{file}: {Stage.CUT.value}" for file, log in logs.items() if log.cut]
        unfinished += [f"{file}: {Stage.GROWING.value}" for file, log in logs.items() if log.stage is Stage.SETTLED]
        if unfinished:
            return WatchedRun(id=run, stage="waiting", lines=unfinished)
        return WatchedRun(id=run, stage="faulty", lines=_shortened(list(map(str, checked.faults))))


def _files_of(campaign: Campaign) -> tuple[dict[str, list[tuple[str, bool]]], list[tuple[str, bool]]]:
    """Return the files of each run, and those of all runs, each with whether it is text of lines.

    Where no run has files of its own, all of the campaign is one, named "".
    """
    manifest = campaign.manifest
    shared = [
        (file, _is_text(campaign, name, file))
        for name, source in manifest.sources.items()
        if source.in_files
        for file in manifest.files_of(name).values()
    ]
    runs: dict[str, list[tuple[str, bool]]] = {}
    for run in manifest.runs:
        own = [
            (file, _is_text(campaign, name, file))
            for name, file in run.files.items()
            if manifest.sources[name].in_files
        ]
        own += [(run.states, True)] if run.states is not None else []
        if own:
            runs[run.id] = own
    if not runs:
        return ({"": []} if shared else {}), list(dict.fromkeys(shared))
    return runs, list(dict.fromkeys(shared))


def _kept(campaign: Campaign, needed: Collection[str], kept: Collection[str]) -> Campaign:
    """Return the campaign with some of the runs that have logs of their own; those without lie in tables, and stay.

    Nothing is said in it of logs whose partner is not there: these are shown as waiting.
    """
    left = with_runs(campaign, {run.id for run in campaign.manifest.runs if run.id in kept or run.id not in needed})
    return left if left.found is None else replace(left, found=replace(left.found, unpartnered=()))


def _begin_from(before: Path, store: Path) -> None:
    """Let a store begin with what another one holds, so that runs are read once; who uses that one goes on with it."""
    try:
        shutil.copytree(before, store, symlinks=True, copy_function=os.link, ignore=shutil.ignore_patterns("lock"))
    except OSError:  # no hard links here: all is read again
        shutil.rmtree(store, ignore_errors=True)


def _without_partner(campaign: Campaign) -> list[WatchedRun]:
    """Return the runs of which a log has come that is named by a pattern, and not yet those of the other sources."""
    if campaign.found is None:
        return []
    sources = campaign.manifest.sources
    return [
        WatchedRun(
            id=entry.run,
            stage="waiting",
            lines=[f"{sources[name].file}: {Stage.ABSENT.value}" for name in entry.lacking],
        )
        for entry in campaign.found.unpartnered
    ]


def _is_text(campaign: Campaign, source: str, file: str) -> bool:
    """Return whether a file is text that ends with the end of a line: a packed one is none."""
    from stiffcal.campaign.found.file_formats import log_format

    found = campaign.manifest.sources[source].format_for(file)
    known = log_format(found) if found == TEXT else None
    return known is not None and not file.lower().endswith(tuple(known.packed_endings))


def _check(campaign: Campaign, run: str, stamp: object) -> _Checked:
    """Return what `check` says of one run.

    Parameters
    ----------
    campaign : without the other runs that have logs of their own. run : its name; "" of tables that hold several.
    """
    try:
        result = check_loaded(campaign)
    except InputError as error:
        return _Checked(stamp, faults=tuple(error.faults))
    own = [entry for entry in result.runs if not run or entry.id == run]
    readings = [entry.n_readings for entry in own if entry.n_readings is not None]
    return _Checked(
        stamp,
        n_states=sum(entry.n_states for entry in own),
        n_readings=sum(readings) if readings else None,
        lines=(*result.warnings, *(f"set aside: {why}" for entry in own for why in entry.set_aside)),
    )


def _shortened(lines: Sequence[str]) -> list[str]:
    more = len(lines) - MOST_LINES
    return [*lines[:MOST_LINES], *([f"and {more} more"] if more > 0 else [])]


def _stamp_of(campaign: Campaign) -> tuple[int, ...]:
    """Return when the files were last written that say how logs are read."""
    paths = (campaign.folder / MANIFEST_FILE, campaign.robot_path)
    return tuple(path.stat().st_mtime_ns if path.exists() else 0 for path in paths)
