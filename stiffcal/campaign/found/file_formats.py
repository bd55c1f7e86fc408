"""The formats of log files: found by walking the folder of the readers, never by import of one.

Why by walking: the manifest lies below the readers, yet names a format, and holds its table of options. A format is
asked for by name and imported only then, so that a campaign of text logs imports no library of another format.
"""

from __future__ import annotations

import importlib
import importlib.metadata
from collections.abc import Iterator
from functools import cache, lru_cache
from typing import Protocol, cast

from stiffcal.campaign.found.found_modules import module_names
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

READERS = "stiffcal.readers"
"""The package whose modules are the formats, and the entry point group of those in other packages."""


class LogFormat(Protocol):
    """What the manifest has to know of a log format; the readers' `Reader` has it all."""

    name: str
    """The format's name, as in ``format = "csv"``; its table of options is called so too."""
    endings: tuple[str, ...]
    """What a file's name may end with, each with its dot, in small letters."""
    packed_endings: tuple[str, ...]
    """Endings of packers behind one of `endings` that are unpacked as well."""
    options: type[TomlTable]
    """The table of options, ``csv = {…}`` of a source."""
    in_files: bool
    """False where the logs are no files: `file` of a source is then a table or a query."""


def format_names() -> tuple[str, ...]:
    """Return the names of all log formats, sorted; nothing is imported for them.

    Examples
    --------
    >>> "csv" in format_names()
    True
    """
    return tuple(sorted({*module_names(READERS), *(point.name for point in _outside())}))


def log_format(name: str) -> LogFormat | None:
    """Return the log format of a name, None where there is none.

    Raises
    ------
    InputError
        A format of another package that cannot be imported.

    Examples
    --------
    >>> log_format("csv").endings[0], log_format("cvs")
    ('.csv', None)
    """
    if name in module_names(READERS):
        return _of_module(name)
    for point in _outside():
        if point.name == name:
            return _from_outside(point)
    return None


def log_formats(first: tuple[str, ...] = ()) -> Iterator[LogFormat]:
    """Yield all log formats, each imported when its turn comes: those named in `first`, the package's, others."""
    names = module_names(READERS)
    for name in sorted(names, key=lambda name: (name not in first, first.index(name) if name in first else 0, name)):
        yield _of_module(name)
    yield from outside_formats()


def outside_formats() -> Iterator[LogFormat]:
    """Yield the log formats of installed packages, each imported when its turn comes."""
    names = module_names(READERS)
    for point in _outside():
        if point.name not in names:
            yield _from_outside(point)


def format_of(file: str) -> str | None:
    """Return the format that a file's ending stands for, None where no format has that ending.

    A format's name is an ending of it, and known without its library: a table of csv is checked without pyarrow.

    Examples
    --------
    >>> format_of("raw/table.CSV"), format_of("raw/pose01.csv.gz"), format_of("raw/pose01.h5.gz")
    ('csv', 'csv', None)
    """
    # as `PurePosixPath.suffix`, which takes ten times as long: ten thousand logs have an ending each
    stem, ending = _parted(file.rstrip("/").rpartition("/")[2])
    return _format_of_endings(ending, _parted(stem)[1], format_names()) if ending else None


def _parted(name: str) -> tuple[str, str]:
    """Return a file's name without its ending, and the ending in small letters; a point alone in front is none.

    Examples
    --------
    >>> _parted("pose01.csv.GZ"), _parted(".csv"), _parted("log."), _parted("log")
    (('pose01.csv', '.gz'), ('.csv', ''), ('log.', ''), ('log', ''))
    """
    point = name.rfind(".")
    if not 0 < point < len(name) - 1:
        return name, ""
    return name[:point], name[point:].lower()


@lru_cache(maxsize=1024)
def _format_of_endings(ending: str, inner: str, names: tuple[str, ...]) -> str | None:
    if (name := ending.removeprefix(".")) in module_names(READERS):
        return name
    for known in log_formats((name, inner.removeprefix("."))):
        if ending in known.endings or (ending in known.packed_endings and inner in known.endings):
            return known.name
    return None


def _of_module(name: str) -> LogFormat:
    return cast(LogFormat, importlib.import_module(f"{READERS}.{name}").READER)


@cache
def _outside() -> tuple[importlib.metadata.EntryPoint, ...]:
    return tuple(importlib.metadata.entry_points(group=READERS))


def _from_outside(point: importlib.metadata.EntryPoint) -> LogFormat:
    try:
        return cast(LogFormat, point.load())
    except Exception as error:  # whatever another package's code raises
        package = point.dist.name if point.dist is not None else point.value
        reason = f"the reader {point.name!r} cannot be imported ({type(error).__name__})"
        raise InputError.at(
            FaultCode.LIBRARY_MISSING, "installed packages", package, reason, "install its package again, or remove it"
        ) from error
