"""Names in logs: columns whose letters are composed in another way than in the manifest, and names of runs.

Unicode writes ``ü`` as one character (NFC, as most keyboards do) or as ``u`` and a mark (NFD, as macOS does); both look
the same, so both name the same column.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from stiffcal.campaign.toml.name_checks import wrong_name
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import Batch, WantedColumns


def names_in_file(wanted: WantedColumns, columns: Callable[[], Sequence[str]]) -> dict[str, str]:
    r"""Return wanted names and what the file calls them, where it composes their letters in another way.

    Parameters
    ----------
    wanted : the columns as the manifest names them.
    columns : reads the names in the file; called only where a wanted
        name can be composed in several ways.

    Examples
    --------
    >>> ascii(names_in_file(WantedColumns(("Fx", "Kr\u00e4fte")), lambda: ["Fx", "Kra\u0308fte"]))
    "{'Kr\\xe4fte': 'Kra\\u0308fte'}"
    """
    if all(name.isascii() for name in wanted.names):
        return {}
    headers = columns()
    header_names = set(headers)
    composed: dict[str, list[str]] = {}
    for column in headers:
        composed.setdefault(_composed(column), []).append(column)
    renamed = {}
    for name in wanted.names:
        same_composed = composed.get(_composed(name), [])
        if name not in header_names and len(same_composed) == 1:
            renamed[name] = same_composed[0]
    return renamed


def in_file_words(wanted: WantedColumns, names: Mapping[str, str]) -> WantedColumns:
    """Return the wanted columns by their names in the file."""

    def renamed(columns: Iterable[str]) -> tuple[str, ...]:
        return tuple(names.get(column, column) for column in columns)

    return replace(
        wanted,
        numbers=renamed(wanted.numbers),
        texts=renamed(wanted.texts),
        times=renamed(wanted.times),
        gaps=frozenset(renamed(wanted.gaps)),
        unjudged=frozenset(renamed(wanted.unjudged)),
    )


def in_manifest_words(batch: Batch, names: Mapping[str, str]) -> Batch:
    """Return a batch by the names that the manifest has."""
    manifest_name = {in_file: name for name, in_file in names.items()}
    return replace(
        batch,
        numbers={manifest_name.get(name, name): values for name, values in batch.numbers.items()},
        texts={manifest_name.get(name, name): words for name, words in batch.texts.items()},
    )


def with_run_names_checked(batches: Iterator[Batch], column: str | None, file: str) -> Iterator[Batch]:
    """Yield batches on, and refuse a name of a run that holds what no name may hold.

    Parameters
    ----------
    batches : as read.
    column : holds the names of the runs; None: no column does.
    file : for the message.

    Raises
    ------
    InputError : a name of a run holds a control character, a separator of lines or the like.
    """
    if column is None:
        yield from batches
        return
    known: set[str] = set()
    for batch in batches:
        for name in set(batch.texts.get(column, ())) - known:
            wrong = wrong_name(name)
            if wrong is not None:
                row = batch.first_row + batch.texts[column].index(name)
                raise InputError.at(FaultCode.NAME_INVALID, file, f"data row {row}, column {column}", *wrong)
            known.add(name)
        yield batch


def _composed(name: str) -> str:
    return unicodedata.normalize("NFC", name)
