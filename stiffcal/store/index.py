"""The index of a generation: what lies in it, how large it is, its SHA-256, and from whom it comes.

An index may have been written by anybody. It names tables and documents, never files: where one lies follows from its
name alone (`file_of`).
"""

from __future__ import annotations

import errno
import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

from stiffcal.documents import Document
from stiffcal.errors import InputError
from stiffcal.escapes import file_name
from stiffcal.fault_codes import FaultCode
from stiffcal.files import MENDS
from stiffcal.plain_files import is_refused, open_inside

SCHEMA = "stiffcal/store/2"
"""Of stiffcal 0.1, whose index holds no hashes."""
INDEX = "generation.json"
OWN, TRUSTED_PLACE, FOREIGN = "own", "trusted place", "foreign"
"""Who computed a result: this user; somebody who writes to a place that this user allowed; or anybody else, whose
results came with the folder and are not verified.
"""
ORIGINS = (OWN, TRUSTED_PLACE, FOREIGN)
REBUILD = "run stiffcal ingest again; the history is kept as far as it is readable"
UPDATE = "update stiffcal"
MOST_BYTES = 1 << 26
"""Of an index: some hundred thousand recordings."""
_MOST_NAME = 1000
_NUMBERED = re.compile(r"(stiffcal/[a-z-]+)/(\d{1,9})")
_SURROGATE = re.compile(rb"\\u[dD][89a-fA-F]")
_SHA256 = re.compile(r"[0-9a-f]{64}")
_MOST_DIGITS = 300
ENDINGS = {"tables": ".parquet", "documents": ".json"}
_KINDS = tuple(ENDINGS)


class DamagedStoreError(InputError):
    """A part of a store cannot be used: it is not what was written, or not there."""


class UnreadableError(InputError):
    """The system does not let a part of a store be read; it may be sound, so nothing is computed or written instead."""


class NewerError(InputError):
    """A part of a store was written by a newer stiffcal."""


def error_of_reading(error: OSError, display_name: str, place: str) -> InputError:
    """Return why a part of a store cannot be used, after the system's own error.

    Parameters
    ----------
    error : from looking at it or opening it.
    display_name : the store's name in messages.
    place : the part.

    Returns
    -------
    InputError
        An `UnreadableError` where the system refuses, a `DamagedStoreError` where the part is missing or no plain
        file.

    Examples
    --------
    >>> print(error_of_reading(PermissionError(13, "Permission denied"), "store", "identify"))
    store: identify: cannot be read (Permission denied); get permission to read it, then do this again \
[store-inaccessible]
    >>> print(error_of_reading(FileNotFoundError(2, "No such file or directory"), "store", "identify"))
    store: identify: damaged (No such file or directory); run stiffcal ingest again; \
the history is kept as far as it is readable [store-damaged]
    """
    text = error.strerror or str(error)
    if not is_refused(error):
        return DamagedStoreError.at(FaultCode.STORE_DAMAGED, display_name, place, f"damaged ({text})", REBUILD)
    no_right = error.errno in (errno.EACCES, errno.EPERM)
    mend = "get permission to read it" if no_right else MENDS.get(error.errno or 0, "check the disk")
    return UnreadableError.at(
        FaultCode.STORE_INACCESSIBLE, display_name, place, f"cannot be read ({text})", f"{mend}, then do this again"
    )


@dataclass(frozen=True)
class Entry:
    """A table or document of a generation."""

    bytes: int
    """Size of its file."""
    rows: int = -1
    """Of a table, else -1."""
    sha256: str = ""
    """Of its file, hexadecimal; "" where the index that held it is damaged."""
    origin: str = OWN
    """From whom it comes, as its writer recorded it."""

    def as_document(self, file: str) -> dict[str, object]:
        """Return the entry as it stands in the index; `file` is for readers outside stiffcal."""
        rows = {} if self.rows < 0 else {"rows": self.rows}
        origin = {} if self.origin == OWN else {"origin": self.origin}
        return {"file": file, **rows, "bytes": self.bytes, "sha256": self.sha256, **origin}


@dataclass(frozen=True)
class Index:
    """What a generation holds."""

    tables: Mapping[str, Entry] = field(default_factory=dict)
    documents: Mapping[str, Entry] = field(default_factory=dict)
    digest: str = ""
    """SHA-256 of the index itself, under which the user's record holds the generation."""

    def of(self, kind: str) -> Mapping[str, Entry]:
        """Return the tables or the documents."""
        return self.tables if kind == "tables" else self.documents

    def files(self) -> dict[str, Entry]:
        """Return every file of the generation, by its path inside it, with its entry."""
        return {file_of(name, ENDINGS[kind]): entry for kind in _KINDS for name, entry in self.of(kind).items()}


def file_of(name: str, ending: str) -> str:
    """Return the path of a table or document inside its generation.

    Slashes make folders; what not every file system can hold is percent-encoded.

    Examples
    --------
    >>> file_of("recordings/pose 1?/ft", ".parquet")
    'recordings/pose 1%3F/ft.parquet'
    """
    pieces = [file_name.stored(piece) for piece in name.split("/")]
    if not all(pieces):
        raise ValueError(f"no name for a table or document: {name!r}")
    return "/".join(pieces) + ending


def read_index(store: Path, place: str, display_name: str) -> Index:
    """Return the index of a generation.

    Parameters
    ----------
    store : the store's folder.
    place : of the generation inside it.
    display_name : the store's name in messages.

    Raises
    ------
    DamagedError
        If the index is not there, or damaged.
    UnreadableError
        If the system does not let it be read.
    NewerError
        If it was written by a newer stiffcal.
    """
    try:
        with open_inside(store, f"{place}/{INDEX}") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise error_of_reading(error, display_name, INDEX) from None
    if len(content) > MOST_BYTES:
        raise DamagedStoreError.at(
            FaultCode.STORE_DAMAGED, display_name, INDEX, f"damaged (more than {MOST_BYTES} bytes)", REBUILD
        )
    return parse_index(content, display_name)


def parse_index(content: bytes, display_name: str) -> Index:
    """Return the content of an index.

    Raises
    ------
    DamagedError
        If it is no index of a store.
    NewerError
        If it was written by a newer stiffcal.
    """
    digest = hashlib.sha256(content).hexdigest()
    index = _last_parsed.get(digest)
    if index is None:
        index = _parsed(content, digest, display_name)
        _last_parsed.clear()
        _last_parsed[digest] = index
    return index


_last_parsed: dict[str, Index] = {}
"""The index that was read last, by its digest: every look at a store reads it, and of ten thousand runs it is long."""


def _parsed(content: bytes, digest: str, display_name: str) -> Index:
    try:
        document = parse_json(content)
        schema = document.get("schema")
        check_version(schema, SCHEMA, display_name, INDEX)
        if schema != SCHEMA:
            raise ValueError(f"schema {str(schema)[:80]!r}")
        tables, documents = (_entries(document[kind], kind) for kind in _KINDS)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise DamagedStoreError.at(
            FaultCode.STORE_DAMAGED, display_name, INDEX, f"damaged ({error})", REBUILD
        ) from None
    return Index(tables, documents, digest)


def _entries(listed: Document, kind: str) -> dict[str, Entry]:
    entries = {}
    for name, entry in listed.items():
        if not 0 < len(name) <= _MOST_NAME or "\0" in name:
            raise ValueError(f"not a name of a table or document: {name[:80]!r}")
        name.encode()  # half a surrogate pair is no name of a file
        file_of(name, ENDINGS[kind])
        rows, size, digest = entry.get("rows", -1), entry["bytes"], entry["sha256"]
        origin = entry.get("origin", OWN)
        if not (_is_count(size) and (rows == -1 or _is_count(rows)) and origin in ORIGINS):
            raise ValueError(f"the entry of {name[:80]!r}")
        if not (isinstance(digest, str) and _SHA256.fullmatch(digest)):
            raise ValueError(f"the hash of {name[:80]!r}")
        entries[name] = Entry(size, rows, digest, origin)
    return entries


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 62


def check_version(schema: object, known: str, display_name: str, place: str) -> None:
    """Raise a `NewerError` where a document's schema is a later one of the same kind.

    Examples
    --------
    >>> check_version("stiffcal/store/1", "stiffcal/store/2", "store", "generation.json")
    >>> check_version("stiffcal/store/9", "stiffcal/store/2", "store", "generation.json")
    Traceback (most recent call last):
    stiffcal.store.index.NewerError: store: generation.json: written by a newer stiffcal (stiffcal/store/9); \
update stiffcal [store-newer]
    """
    version = _NUMBERED.fullmatch(schema) if isinstance(schema, str) else None
    ours = _NUMBERED.fullmatch(known)
    if version is not None and ours is not None and version[1] == ours[1] and int(version[2]) > int(ours[2]):
        raise NewerError.at(
            FaultCode.STORE_NEWER, display_name, place, f"written by a newer stiffcal ({schema})", UPDATE
        )


def parse_json(content: bytes) -> Document:
    """Return a JSON object that anybody may have written.

    Raises
    ------
    ValueError
        It is not a JSON object in UTF-8, nested too deeply, or holds NaN, infinity, an endless number or half a
        character.

    Examples
    --------
    >>> parse_json(b'{"a": [1, 2.5]}')
    {'a': [1, 2.5]}
    >>> parse_json(b'{"a": NaN}')
    Traceback (most recent call last):
    ValueError: NaN is not a JSON number
    """
    try:
        document = json.loads(content.decode("utf-8"), parse_constant=_no_number, parse_int=_integer, parse_float=_real)
        if _SURROGATE.search(content):  # a pair is one character; half of one cannot be written again
            json.dumps(document, ensure_ascii=False).encode()
    except RecursionError:
        raise ValueError("nested too deeply") from None
    except UnicodeEncodeError:
        raise ValueError("a text with an incomplete character") from None
    if not isinstance(document, dict):
        raise ValueError("not a JSON object")
    return document


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a JSON number")


def _integer(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text)


def _real(text: str) -> float:
    value = float(text)
    if value - value != 0.0:  # infinite or NaN
        raise ValueError(f"{text[:40]} is beyond all numbers")
    return value
