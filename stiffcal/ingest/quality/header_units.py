"""Units that stand in a log, in its column names or next to them, against those that the manifest states.

The manifest counts. A log that states another unit is most often right, and its readings then come out wrong by a fixed
factor that nothing else shows.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from stiffcal.campaign.columns.column_headers import header_parts, is_unit
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.quantities import Unit, UnknownUnitError, unit
from stiffcal.wording import count, listing

# Logs of a source that are named one by one.
_MOST_FILES = 3


def declared_units(source: Source) -> dict[str, Unit]:
    """Return the unit of each column of a source, as the manifest states it."""
    declared = {
        column: of_column
        for signal in source.signals().values()
        for column, of_column in signal.columns_with_units().items()
    }
    time = source.time
    if time is not None and time.column is not None and not time.in_words:
        declared[time.column] = unit(time.unit or "s", "time")
    if time is not None and time.fraction is not None:
        declared[time.fraction] = unit(time.fraction_unit or "s", "time")
    return declared


def unit_conflicts(source: Source, stated_apart: Mapping[str, str]) -> tuple[str, ...]:
    """Return one sentence for each unit of a log that is not the one that the manifest states.

    Parameters
    ----------
    source : what the manifest states. stated_apart : units of a row under the names, or of attributes, by column.
    """
    conflicts: dict[tuple[str, str, str], list[str]] = {}
    for column, declared in declared_units(source).items():
        written = header_parts(column).unit or stated_apart.get(column)
        if written is None or _same(written, declared):
            continue
        conflicts.setdefault((written, declared.name, declared.quantity), []).append(column)
    return tuple(
        f"column{'s' * (len(columns) > 1)} {listing(columns)}: the log states {written}, {MANIFEST_FILE} {declared} "
        f"({quantity}): {declared} is taken; correct units there if the log is right"
        for (written, declared, quantity), columns in conflicts.items()
    )


def _same(written: str, declared: Unit) -> bool:
    """Return whether a unit of a log is the declared one; what is no unit at all, as "-", contradicts nothing."""
    try:
        stated = unit(written, declared.quantity)
    except UnknownUnitError:
        return not is_unit(written)
    return (stated.factor, stated.offset) == (declared.factor, declared.offset)


def conflict_warnings(of_file: Iterable[tuple[str, tuple[str, ...]]]) -> list[str]:
    """Return one warning for the files that contradict the manifest in the same way.

    Parameters
    ----------
    of_file : each file, and its sentences.
    """
    files: dict[str, list[str]] = {}
    for file, sentences in of_file:
        for sentence in sentences:
            named = files.setdefault(sentence, [])
            named += [file] if file not in named else []
    return [
        ", ".join(named[:_MOST_FILES])
        + (f" and {count(len(named) - _MOST_FILES, 'more file')}" if len(named) > _MOST_FILES else "")
        + f": {sentence}"
        for sentence, named in files.items()
    ]
