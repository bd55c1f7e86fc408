"""The interface of a log format, and how formats are found.

A format is one module in this folder, named like the format, with one class derived from `Reader` and one instance of
it called ``READER``. Nothing else has to be edited: the folder is walked, the class declares the endings of its
files, which options a manifest may hold for it, and what the tests of hostile input start from. A package outside
stiffcal adds a format through the entry point group ``stiffcal.readers`` (name: the format, value: the instance).

Why batches: a log can be larger than memory, so every reader yields pieces of bounded size and every stage behind it
takes them one by one. Why no repair: a reader yields the numbers that stand in the file or raises `InputError`; what
may be left out is the caller's decision, never the reader's.
"""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, cast

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.found.file_formats import format_names, log_format, log_formats, outside_formats
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular, open_regular
from stiffcal.log_columns import (
    Batch,
    Options,
    WantedColumns,
    batch_of_columns,
    check_columns,
    check_there,
    common_length,
    damaged_file_errors,
    first_not_finite,
    missing_library,
    nearest_name,
    text_of,
)
from stiffcal.log_options import check_options, nearest_option
from stiffcal.parsers.client import ParsedFile
from stiffcal.parsers.signatures import LENGTH_OF_START, not_a_log

__all__ = [
    "Batch",
    "DatabaseReader",
    "FuzzInput",
    "Header",
    "NoOptions",
    "Options",
    "ParsedReader",
    "Reader",
    "WantedColumns",
    "batch_of_columns",
    "check_columns",
    "check_is_log",
    "check_options",
    "check_there",
    "common_length",
    "damaged_file_errors",
    "find_reader",
    "first_not_finite",
    "missing_library",
    "nearest_name",
    "nearest_option",
    "text_of",
]


@dataclass(frozen=True)
class Header:
    """A log's own description."""

    columns: tuple[str, ...]
    """The names of all columns, in order."""
    units: dict[str, str] = field(default_factory=dict)
    """Column name to the unit that the log itself states (a unit row, an attribute), where it does."""
    n_rows: int | None = None
    """The number of data rows where the format states it without reading them, else None."""
    options: dict[str, object] = field(default_factory=dict)
    """The options as understood, detected ones included (a delimiter that was not given)."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the log, in words: rows that a spreadsheet hides."""
    uneven: bool = False
    """Whether columns are known to be of different lengths."""


class NoOptions(TomlTable):
    """Nothing to say: files of the format describe themselves."""


@dataclass(frozen=True)
class FuzzInput:
    """A small valid log of a format, which tests read back, and spoil to see that it is refused in one line."""

    ending: str
    """What its file's name ends with; a format whose logs are folders names a file that it reads as well."""
    write: Callable[[Path], None]
    """Writes the log to a path."""
    numbers: tuple[str, ...]
    """Names of its columns of numbers."""
    texts: tuple[str, ...] = ()
    """Names of its columns of words."""
    options: Mapping[str, object] = field(default_factory=dict)
    """The format's options with which it is read."""


@dataclass(frozen=True)
class RawRows:
    """Rows of a log as they stand in its file."""

    columns: tuple[str, ...] = ()
    """The file's columns."""
    lines: Mapping[int, tuple[int, str]] = field(default_factory=dict)
    """Data row (from 1) to the number of its line and the line, without its end."""


class Reader(ABC):
    """A log format. `display_name` is the file as the user named it, for messages; default: the path itself."""

    name: ClassVar[str]
    """The name of the reader's module."""
    endings: ClassVar[tuple[str, ...]] = ()
    """What a file's name may end with, each with its dot, in small letters."""
    first_bytes: ClassVar[bytes] = b""
    """What each of its files begins with; empty where that identifies nothing."""
    packed_endings: ClassVar[tuple[str, ...]] = ()
    """Endings of packers behind one of `endings` that are unpacked as well."""
    options: ClassVar[type[TomlTable]] = NoOptions
    """The table of options of a source, ``csv = {…}``; its fields are what `read_batches` is given."""
    header_at_once: ClassVar[bool] = False
    """True where names and units are the first lines of a file, and need no library to be read."""
    has_remarks: ClassVar[bool] = False
    """True where a header may hold remarks, so that every file's is read."""
    holds_tables: ClassVar[bool] = False
    """True where a file may hold several tables: sheets, groups, topics."""
    in_files: ClassVar[bool] = True
    """False where the logs are no files: `file` of a source is then a table or a query; see `DatabaseReader`."""
    fuzz_inputs: ClassVar[tuple[FuzzInput, ...]] = ()
    """What tests of hostile input start from; none only where the logs are no files."""

    def recognises(self, path: Path) -> bool:
        """Return True where the file's ending or first bytes are of this format."""
        if path.suffix.lower() in self.endings:
            return True
        if not self.first_bytes:
            return False
        try:
            with open_regular(path) as file:
                return file.read(len(self.first_bytes)) == self.first_bytes
        except OSError:
            return False

    def tables(self, path: Path, display_name: str = "") -> tuple[Options, ...]:
        """Return the tables in a file, each as the options that choose it: none where it holds one table."""
        return ({},)

    @abstractmethod
    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns; with `wanted`, check that these are there."""

    @abstractmethod
    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in order, streamed. Raises `InputError` at the first fault, with its place."""

    def first_rows(
        self, path: Path, options: Options, names: Sequence[str], display_name: str = ""
    ) -> dict[str, Floats | list[str]]:
        """Return the first rows of columns of unknown kind: (n,) numbers, NaN for gaps, or n words.

        A column that is neither is left out.
        """
        found: dict[str, Floats | list[str]] = {}
        for name in names:
            for wanted in (WantedColumns((name,), gaps=frozenset((name,))), WantedColumns((), (name,))):
                with suppress(InputError):
                    batch = next(iter(self.read_batches(path, options, wanted, display_name)), None)
                    found |= {} if batch is None else {**batch.numbers, **batch.texts}
                if name in found:
                    break
        return found

    @abstractmethod
    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return the place of data row `row` (from 1) in the file, e.g. ``line 12``."""

    def raw_rows(self, path: Path, options: Options, rows: Collection[int]) -> RawRows:
        """Return some data rows (from 1) as they stand in the file; nothing of a format that is no text."""
        return RawRows()

    def row_lines(self, path: Path, options: Options) -> Integers | None:
        """Return the line of each data row, (n,); None of a format that is no text."""
        return None


class ParsedReader(Reader):
    """A binary format, whose files a module of its name in `stiffcal.parsers` parses, in a child process."""

    def tables(self, path: Path, display_name: str = "") -> tuple[Options, ...]:
        """Return the tables in a file, where the format may hold several.

        Raises
        ------
        InputError
            The file is damaged, or its parsing takes more than is allowed.
        """
        return self._file(path, {}, display_name or str(path)).tables() if self.holds_tables else ({},)

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns, and the units and number of rows that the file states."""
        found = self._file(path, options, display_name or str(path)).header(wanted)
        return Header(found.columns, dict(found.units), found.n_rows, dict(found.options), found.remarks, found.uneven)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, one that leads to others, a missing column, columns of unequal length, a
            cell that is no finite number; for one whose parsing takes more than is allowed.
        """
        yield from self._file(path, options, display_name or str(path)).batches(wanted)

    def first_rows(
        self, path: Path, options: Options, names: Sequence[str], display_name: str = ""
    ) -> dict[str, Floats | list[str]]:
        """Return the first rows of columns of unknown kind, as the parser finds them."""
        return self._file(path, options, display_name or str(path)).first_rows(names)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"

    def _file(self, path: Path, options: Options, display_name: str) -> ParsedFile:
        check_options(options, self.options, self.name, display_name)
        check_there(path, display_name)
        return ParsedFile(self.name, path, options, display_name)


class DatabaseReader(Reader):
    """A format whose logs are no files: `file` of the manifest reaches it as the option ``from``."""

    in_files = False

    @abstractmethod
    def fingerprint(self, options: Options) -> tuple[int, str]:
        """Return the number of rows and a text that changes with what is read."""


def find_reader(path: Path, log_format_name: str | None = None, display_name: str = "") -> Reader:
    """Return the reader for a file: by the format's name, else by the file's ending, else by its first bytes.

    Raises
    ------
    InputError
        If no format of this name is known, or none recognises the file.
    """
    if log_format_name is not None:
        log_format_found = log_format(log_format_name)
        if log_format_found is None:
            reason, known = f"no reader for format {log_format_name!r}", format_names()
            raise InputError.at(
                FaultCode.FORMAT_UNKNOWN,
                display_name or str(path),
                "format",
                reason,
                _suggest_format(log_format_name, known),
            )
        return cast(Reader, log_format_found)
    with suppress(OSError):  # what is not there at all has no format
        check_regular(path, display_name)
    # The module named like the ending first, so that a .csv does not import h5py.
    for known_format in log_formats(tuple(suffix.lstrip(".").lower() for suffix in reversed(path.suffixes))):
        reader = cast(Reader, known_format)
        if reader.recognises(path):
            return reader if path.suffix.lower() in reader.endings else _with_ending(path) or reader
    check_is_log(path, display_name)
    raise InputError.at(
        FaultCode.FORMAT_UNKNOWN,
        display_name or str(path),
        "",
        "the format cannot be determined from the file",
        f"write format = one of {', '.join(format_names())} in its source",
    )


def check_is_log(path: Path, display_name: str = "", start: bytes | None = None) -> None:
    """Raise an `InputError` for what lies next to logs and is none: a document, a picture, an archive, a program.

    Parameters
    ----------
    start : its first bytes, unpacked where it is packed; None: they are read.
    """
    if start is None:
        try:
            with open_regular(path) as file:
                start = file.read(LENGTH_OF_START)
        except OSError:
            return
    found = not_a_log(start[:LENGTH_OF_START])
    if found is not None:
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, display_name or str(path), "", f"{found[0]}, no log", found[1])


def _with_ending(path: Path) -> Reader | None:
    """Return the reader of an installed package that has a file's ending, which begins like another format."""
    readers = (cast(Reader, known_format) for known_format in outside_formats())
    return next((reader for reader in readers if path.suffix.lower() in reader.endings), None)


def _suggest_format(name: str, known: Sequence[str]) -> str:
    suggestions = difflib.get_close_matches(name.lower(), known, n=1, cutoff=0.6)
    return f"did you mean {suggestions[0]!r}?" if suggestions else f"formats: {', '.join(known)}"
