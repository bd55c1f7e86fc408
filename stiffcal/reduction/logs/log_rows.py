"""A source's rows as the manifest describes them: streamed, in SI, in the instrument's own axes."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.toml.toml_reading import LARGEST
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import unit
from stiffcal.readers import Batch, DatabaseReader, Header, RawRows, WantedColumns, find_reader
from stiffcal.reduction.logs.excluded_rows import RowExclusions
from stiffcal.reduction.logs.instrument_readings import instrument_readings
from stiffcal.reduction.logs.kept_rows import (
    KeptRows,
    check_sizes,
    columns_with_gaps,
    first_missing,
    kept_rows,
    unjudged_columns,
)
from stiffcal.reduction.logs.names import in_file_words, in_manifest_words, names_in_file, with_run_names_checked

NOTHING_EXCLUDED = RowExclusions()


@dataclass(frozen=True)
class LogRows:
    """Consecutive rows of a source, in SI and in the instrument's axes, channels first."""

    number: Integers
    """(n,) data row in the file, from 1, header not counted."""
    time: Floats
    """(n,) s on the device's clock; NaN where none is logged."""
    run: list[str]
    """The n names of the run column, or empty."""
    signals: dict[str, Floats]
    """Name to (c, n). ``joints`` rad, ``wrench`` (6) N, N·m as it acts on the robot, ``mass`` kg, ``position.BODY`` m
    and ``quaternion.BODY`` w x y z in the pose's frame, ``marker.BODY.NAME`` m, ``translation`` m and ``rotation`` rad
    of a deflection, ``displacement.SOURCE`` m, ``lengths.ROD`` m, ``temperature`` K, ``hold`` s, and what else a
    controller logs: ``joints.command``, ``joints.velocity``, ``joints.torque``, ``joints.approach`` (its sign counts).
    """

    def __len__(self) -> int:
        return int(self.number.shape[0])

    def chosen(self, keep: NDArray[np.bool_]) -> LogRows:
        """Return the rows of a mask (n,)."""
        run = [name for name, kept in zip(self.run, keep, strict=True) if kept] if self.run else []
        signals = {name: values[:, keep] for name, values in self.signals.items()}
        return LogRows(self.number[keep], self.time[keep], run, signals)


def read_rows(
    folder: Path,
    name: str,
    source: Source,
    files: Mapping[str, str],
    observer: Callable[[LogRows], None] | None = None,
    exclusions: RowExclusions = NOTHING_EXCLUDED,
    metres_of_rods: Mapping[str, float] | None = None,
) -> Iterator[LogRows]:
    """Yield the rows of a source, streamed; rows that are left out come too, and may hold anything.

    Parameters
    ----------
    folder : the campaign folder.
    name : the source's name, for messages.
    files : signal name to file; ``""`` for a file that holds all signals.
    observer : called with the rows that are not left out, as they come; it may raise.
    exclusions : the rows that are left out: they are not checked, and what is no number there is NaN.
    metres_of_rods : metres of a unit of each rod's reading; needed where the source logs rods.

    Raises
    ------
    InputError
        A file is missing or faulty, with file, line and column.
    """
    if not files:
        raise InputError.at(
            FaultCode.KEY_MISSING, "campaign.toml", f"[sources.{name}]", "no file is named", 'add file = "raw/….csv"'
        )
    optional = columns_with_gaps(source)
    unjudged = unjudged_columns(source, exclusions)
    for batch in _batches(folder, source, files, optional | unjudged, unjudged):
        kept = kept_rows(source, batch)
        excluded = exclusions.mask(kept.number, kept.run)
        judged = kept.chosen(~excluded) if excluded.any() else kept
        missing = first_missing(judged, optional)
        if missing is not None:
            raise _missing_reading(folder, name, source, files, *missing)
        check_sizes(judged, files)
        rows = _as_rows(kept, source, name, excluded, metres_of_rods)
        if observer is not None:
            observer(rows.chosen(~excluded) if excluded.any() else rows)
        yield rows


def _as_rows(
    kept: KeptRows, source: Source, name: str, excluded: Booleans, metres_of_rods: Mapping[str, float] | None
) -> LogRows:
    """Return the rows in SI; what is left out and no number of any use is NaN."""
    numbers = kept.numbers
    if excluded.any():
        numbers = {
            column: np.where(excluded & ~(np.abs(values) <= LARGEST), np.nan, values)
            for column, values in numbers.items()
        }
    readings = instrument_readings(source, numbers, name, metres_of_rods)
    return LogRows(kept.number, _time(source, numbers, kept.number), kept.run, readings)


def _missing_reading(
    folder: Path, name: str, source: Source, files: Mapping[str, str], row: int, column: str
) -> InputError:
    place = place_of_row(folder, source, files[""], row) if "" in files else f"data row {row}"
    lines = (toml_text.pair("source", name), toml_text.pair("rows", [row]), 'why = "no reading"')
    mend = f"give the reading, or exclude the row: [[exclude]] with {', '.join(lines)}"
    display_name = ", ".join(dict.fromkeys(files.values()))
    return InputError.at(
        FaultCode.CELL_EMPTY, display_name, f"{place}, column {column}", "the reading is missing (empty or NaN)", mend
    )


def columns_of_signals(source: Source, name: str = "") -> dict[str, tuple[str, ...]]:
    """Return the columns of each signal of `LogRows`, as the file names them; ``name`` is the source's."""
    columns_of: dict[str, tuple[str, ...]] = {}
    if source.joints is not None:
        for key, columns in source.joints.groups().items():
            columns_of["joints" if key == "position" else f"joints.{key}"] = columns
    if source.wrench is not None:
        columns_of["wrench"] = source.wrench.columns
    for body, pose in source.body_poses().items():
        columns_of[f"position.{body}"] = pose.position or ()
        columns_of |= {f"marker.{body}.{name}": marker.columns for name, marker in pose.markers.items()}
        columns_of[f"quaternion.{body}"] = pose.orientation[1] if pose.orientation else ()
    if source.deflection is not None:
        columns_of["translation"], columns_of["rotation"] = (
            source.deflection.translation,
            source.deflection.rotation or (),
        )
    if source.displacement is not None:
        columns_of[f"displacement.{name}"] = (source.displacement.column,)
    if source.lengths is not None:
        columns_of |= {f"lengths.{rod}": (rod,) for rod in source.lengths.columns}
    if source.temperature is not None:
        columns_of["temperature"] = source.temperature.columns
    return columns_of


def files_of_signals(source: Source, name: str = "") -> dict[str, str]:
    """Return the file of each signal of `LogRows` that has one of its own; empty where one file holds all signals."""
    bodies = {pose.body or "target": "pose" for pose in ([source.pose] if source.pose is not None else [])}
    bodies |= {pose.body or body: f"poses.{body}" for body, pose in source.poses.items()}
    file_of = {}
    for signal in columns_of_signals(source, name):
        kind, _, rest = signal.partition(".")
        if kind in ("position", "marker", "quaternion"):
            kind = bodies.get(rest if kind != "marker" else rest.rpartition(".")[0], kind)
        kind = "deflection" if kind in ("translation", "rotation") else kind
        if kind in source.files:
            file_of[signal] = source.files[kind]
    return file_of


def _time(source: Source, numbers: Mapping[str, Floats], number: Integers) -> Floats:
    """Return seconds on the device's clock."""
    axis = source.time
    if axis is None:
        return np.full(number.size, np.nan)
    if axis.rate_hz is not None:
        return np.asarray((number - 1) / axis.rate_hz)
    factor = 1.0 if axis.in_words else unit(axis.unit or "s", "time").factor
    time = numbers[axis.column or ""] * factor
    if axis.fraction is not None:
        time = time + numbers[axis.fraction] * unit(axis.fraction_unit or "s", "time").factor
    return np.asarray(time)


def reader_options(source: Source, log_format: str, file: str = "") -> dict[str, object]:
    """Return the manifest's options of a format, as the reader wants it; with the table or query that is no file."""
    options = source.options_of(log_format)
    return options if source.in_files else options | {"from": file}


def _batches(
    folder: Path, source: Source, files: Mapping[str, str], gaps: frozenset[str], unjudged: frozenset[str]
) -> Iterator[Batch]:
    if set(files) == {""}:
        yield from read_batches(folder, source, files[""], wanted_columns(source, None, gaps, unjudged))
        return
    yield _side_by_side(folder, source, files, gaps, unjudged)


def read_batches(folder: Path, source: Source, file: str, wanted: WantedColumns) -> Iterator[Batch]:
    """Yield the batches of one file of a source, as they stand there."""
    path = folder / file
    if not is_there(folder, source, file):
        raise InputError.at(
            FaultCode.FILE_MISSING, file, "", "no such file", "correct its name in campaign.toml, or add the log"
        )
    reader = find_reader(path, source.format_for(file), file)
    options = reader_options(source, reader.name, file)
    names = names_in_file(wanted, lambda: reader.read_header(path, options, file).columns)
    batches = reader.read_batches(path, options, in_file_words(wanted, names) if names else wanted, file)
    if names:
        batches = (in_manifest_words(batch, names) for batch in batches)
    yield from with_run_names_checked(batches, source.run.column if source.run is not None else None, file)


def is_there(folder: Path, source: Source, file: str) -> bool:
    """Check whether a source's file is there; of what is no file that shows when it is read."""
    # tens of thousands of logs: Path takes ten times as long
    return not source.in_files or os.path.exists(f"{folder}/{file}")  # noqa: PTH110


def fingerprint_of(source: Source, file: str) -> tuple[int, str]:
    """Return the number of rows and a digest of a table or query that is no file.

    Raises
    ------
    InputError
        It cannot be reached.
    """
    reader = cast(DatabaseReader, find_reader(Path(file), source.format, file))
    return reader.fingerprint(reader_options(source, reader.name, file))


def place_of_row(folder: Path, source: Source, file: str, row: int) -> str:
    """Return the place of data row ``row`` (from 1) in the file."""
    reader = find_reader(folder / file, source.format_for(file), file)
    return str(reader.place_of_row(folder / file, reader_options(source, reader.name, file), row))


def header_at_once(folder: Path, source: Source, file: str) -> bool:
    """Return whether reading a file's header takes no time to speak of, or it may hold remarks."""
    reader = find_reader(folder / file, source.format_for(file), file)
    return reader.header_at_once or reader.has_remarks


def header_of_file(folder: Path, source: Source, file: str) -> Header:
    """Return what a file of which rows were read states of itself: units next to its columns' names, and remarks."""
    path = folder / file
    reader = find_reader(path, source.format_for(file), file)
    options = reader_options(source, reader.name, file)
    if source.files:
        return reader.read_header(path, options, file)
    wanted = wanted_columns(source, None)  # as where its rows are read: the layout of a text is found once
    names = names_in_file(wanted, lambda: reader.read_header(path, options, file).columns)
    return reader.read_header(path, options, file, in_file_words(wanted, names) if names else wanted)


def raw_rows_of(folder: Path, source: Source, file: str, rows: Collection[int]) -> RawRows:
    """Return data rows (from 1) as they stand in the file; nothing where the format is no text."""
    reader = find_reader(folder / file, source.format_for(file), file)
    return reader.raw_rows(folder / file, reader_options(source, reader.name, file), rows)


def wanted_columns(
    source: Source,
    signals: tuple[str, ...] | None,
    gaps: frozenset[str] = frozenset(),
    unjudged: frozenset[str] = frozenset(),
) -> WantedColumns:
    """Return the columns to read of a file: all of the source, or those of some of its signals.

    Parameters
    ----------
    source : the source.
    signals : the signals' names; None: all.
    gaps : columns in which a cell without a number is read as NaN.
    unjudged : columns in which a cell may hold anything: what is no number is infinite.
    """
    texts: list[str] = []
    times: list[str] = []
    numbers: list[str] = []
    if source.run is not None and source.run.column is not None and signals is None:
        texts.append(source.run.column)
    if source.time is not None and source.time.column is not None and signals is None:
        (times if source.time.in_words else numbers).append(source.time.column)
        numbers += source.time.columns[1:]
    chosen = [signal for name, signal in source.signals().items() if signals is None or name in signals]
    conditions = source.row_conditions if signals is None else [c for signal in chosen for c in signal.row_conditions]
    numbers += [column for signal in chosen for column in signal.column_names()]
    numbers += [column for signal in chosen for columns in signal.sigma_columns().values() for column in columns]
    for condition in conditions:
        in_words = isinstance(condition.value, str) and not (condition.value == "" and condition.column in numbers)
        (texts if in_words else numbers).append(condition.column)
    return WantedColumns(
        tuple(dict.fromkeys(numbers)),
        tuple(dict.fromkeys(texts)),
        tuple(dict.fromkeys(times)),
        gaps.intersection((*numbers, *texts)),
        unjudged.intersection(numbers),
        source.time.date_order if source.time is not None else "",
    )


def _of_column(source: Source, signal: str, column: str) -> WantedColumns:
    """Return the column of the run's names, or of the time, as the one that is wanted."""
    if signal == "run":
        return WantedColumns((), (column,))
    fraction = source.time.columns[1:] if source.time is not None else ()
    if source.time is not None and source.time.in_words:
        return WantedColumns(fraction, (), (column,), date_order=source.time.date_order)
    return WantedColumns((column, *fraction))


def _side_by_side(
    folder: Path, source: Source, files: Mapping[str, str], gaps: frozenset[str], unjudged: frozenset[str]
) -> Batch:
    """Return the columns of several files of equal length as one batch (tables of states: they fit into memory)."""
    numbers: dict[str, Floats] = {}
    texts: dict[str, list[str]] = {}
    lengths: dict[str, int] = {}
    extra = {"run": source.run.column if source.run else None, "time": source.time.column if source.time else None}
    for signal, file in files.items():
        wanted = wanted_columns(source, (signal,), gaps, unjudged)
        if signal in extra and extra[signal] is not None:
            column = str(extra[signal])
            wanted = _of_column(source, signal, column)
        if not wanted.names:
            raise InputError.at(
                FaultCode.SOURCE_UNKNOWN,
                "campaign.toml",
                f"files.{signal}",
                "no such signal",
                "name a signal of this source",
            )
        batches = list(read_batches(folder, source, file, wanted))
        for column in wanted.names:
            if batches and column in batches[0].texts:
                texts[column] = [word for batch in batches for word in batch.texts[column]]
            else:
                numbers[column] = np.concatenate([batch.numbers[column] for batch in batches])
        lengths[file] = sum(len(batch) for batch in batches)
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{file} {count}" for file, count in lengths.items())
        raise InputError.at(
            FaultCode.SHAPE_MISMATCH,
            next(iter(lengths)),
            "",
            f"the files of one source differ in length (rows: {counts})",
            "make them the same length",
        )
    return Batch(1, numbers, texts)
