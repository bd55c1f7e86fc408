"""Tables in which each row is one averaged load state, as raw states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Protocol

import numpy as np

from stiffcal.campaign.frames.gauges import metres_of_rods
from stiffcal.campaign.manifest.manifest import Manifest, Run
from stiffcal.campaign.manifest.source import Source
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.set_aside import IN_USE, SetAside, SetAsideCode
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.logs.excluded_rows import RowExclusions
from stiffcal.reduction.logs.log_rows import LogRows, place_of_row, read_rows
from stiffcal.reduction.logs.motor_side import MotorSide
from stiffcal.reduction.states.raw_states import RawStates, concatenated, joined_side_by_side, pick


class TableReadings(Protocol):
    """What is noticed in tables while they are read, and what reading those of single runs gave earlier."""

    def update(self, source: str, file: str, rows: LogRows) -> None:
        """Look at rows as they come, those that the manifest leaves out excepted; may raise."""

    def earlier(self, source: str, run: Run) -> RawStates | None:
        """Return the states of a run's own table, None where it has to be read."""

    def finish(self, source: str, file: str, run: Run | None, states: RawStates) -> None:
        """Take in the states of a table that was read to its end, of one run or of all."""


def tabled_states(
    folder: Path, manifest: Manifest, chain: Chain, readings: TableReadings | None = None
) -> RawStates | None:
    """Read the sources that hold one row per load state; None where there is none.

    Several such sources go together row by row within each run.

    Parameters
    ----------
    readings : returns what was read of a run's table before, and stores what is read now; None: all are read.

    Raises
    ------
    InputError
        Tables do not fit together, a file is faulty, time runs backwards.
    """
    raw_states: RawStates | None = None
    for name, source in manifest.sources.items():
        if not source.is_states:
            continue
        tables = []
        for run, files in _files(manifest, name):
            display_name = next(iter(files.values()), "")
            known = None if readings is None or run is None else readings.earlier(name, run)
            if known is not None:
                tables.append(known)
                continue
            motors = MotorSide(source, chain, name, starts_anew=False)
            observe = None
            if readings is not None:
                observe = partial(_observe, partial(readings.update, name, display_name), motors)
            exclusions = RowExclusions.of(manifest, name, None if run is None else run.id)
            read = read_rows(folder, name, source, files, observe, exclusions, metres_of_rods(manifest))
            rows = _signals_together(list(motors.all(read)))
            tables.append(_with_labels(manifest, name, run, rows, display_name))
            _check_order(tables[-1], display_name, partial(_place, folder, source, files))
            if readings is not None:
                readings.finish(name, display_name, run, tables[-1])
        table = concatenated(tables)
        raw_states = table if raw_states is None else joined_side_by_side(raw_states, table, name)
    return None if raw_states is None else _without_unreadable(raw_states)


def _observe(observer: Callable[[LogRows], None], motors: MotorSide, rows: LogRows) -> None:
    observer(motors.joint_side(rows))


def _files(manifest: Manifest, source: str) -> list[tuple[Run | None, dict[str, str]]]:
    """Return the files of a table source: one table for all runs, or one for each run that names one."""
    run_files = [(run, manifest.files_of(source, run)) for run in manifest.runs if source in run.files]
    if run_files:
        return [(run, files) for run, files in run_files]
    return [(None, manifest.files_of(source))]


def _signals_together(tables: Sequence[LogRows]) -> LogRows:
    return LogRows(
        np.concatenate([rows.number for rows in tables]),
        np.concatenate([rows.time for rows in tables]),
        [word for rows in tables for word in rows.run],
        {name: np.concatenate([rows.signals[name] for rows in tables], axis=1) for name in tables[0].signals},
    )


def _with_labels(manifest: Manifest, name: str, run: Run | None, rows: LogRows, display_name: str) -> RawStates:
    """Give every row its run, its exclusion, and states first."""
    source = manifest.sources[name]
    n = len(rows)
    if run is not None:
        labels = [run.id] * n
    elif rows.run:
        labels = rows.run
    elif source.run is not None and source.run.each == "row":
        labels = [str(number) for number in rows.number]
    elif len(manifest.runs) == 1:
        labels = [manifest.runs[0].id] * n
    else:
        raise InputError.at(
            FaultCode.KEY_MISSING, "campaign.toml", f"[sources.{name}]", "it is not stated to which run each row "
        "belongs",
            'add run = { column = "run" } or run = { each = "row" }',
        )  # fmt: skip
    reasons = [IN_USE] * n
    for exclusion in manifest.exclude:
        if exclusion.source != name:
            continue
        rows_out = set(exclusion.rows)
        beyond = rows_out - set(rows.number.tolist())
        if beyond and exclusion.run is None:
            reason = f"there is no data row {min(beyond)} in {display_name}"
            raise InputError.at(
                FaultCode.ROW_UNKNOWN, "campaign.toml", "exclude", reason, "count data rows from 1, the header left out"
            )
        for k in range(n):
            if int(rows.number[k]) in rows_out and exclusion.run in (None, labels[k]):
                reasons[k] = SetAside(SetAsideCode.EXCLUDED, f"excluded in the manifest: {exclusion.why}")
    hold = rows.signals["hold"][0] if "hold" in rows.signals else np.full(n, np.nan)
    raw_states = RawStates(
        labels, rows.number, rows.time, hold,
        {signal: np.ascontiguousarray(values.T) for signal, values in rows.signals.items() if signal != "hold"},
        {}, np.ones(n, dtype=np.int64), reasons,
    )  # fmt: skip
    return _by_run(raw_states)


def _without_unreadable(raw_states: RawStates) -> RawStates:
    """Drop the rows that the manifest leaves out and that hold no angles or loads: there is no state to set aside."""
    excluded = np.array([reason.code is SetAsideCode.EXCLUDED for reason in raw_states.set_aside], dtype=np.bool_)
    unreadable = np.zeros_like(excluded)
    for name in ("joints", "wrench", "mass"):
        if name in raw_states.signals:
            unreadable |= ~np.isfinite(raw_states.signals[name]).all(axis=1)
    return pick(raw_states, ~(excluded & unreadable)) if (excluded & unreadable).any() else raw_states


def _by_run(raw_states: RawStates) -> RawStates:
    """Bring the states of each run together, order within a run kept."""
    first: dict[str, int] = {}
    for name in raw_states.run:
        first.setdefault(name, len(first))
    index = np.array([first[name] for name in raw_states.run], dtype=np.int64)
    order = np.argsort(index, kind="stable")
    return pick(raw_states, order)


def _check_order(states: RawStates, display_name: str, place: Callable[[int], str]) -> None:
    """Raise where time runs backwards within a run."""
    same = np.array([a == b for a, b in pairwise(states.run)], dtype=np.bool_)
    backwards = np.flatnonzero(same & (np.diff(states.time) < 0.0))
    if backwards.size:
        k = int(backwards[0]) + 1
        raise InputError.at(
            FaultCode.TIME_ORDER, display_name, place(int(states.number[k])),
            f"time decreases in run {states.run[k]}: {states.time[k]:g} s after {states.time[k - 1]:g} s",
            "sort the rows in measuring order, or omit the time",
        )  # fmt: skip


def _place(folder: Path, source: Source, files: Mapping[str, str], row: int) -> str:
    return place_of_row(folder, source, files[""], row) if "" in files else f"data row {row}"
