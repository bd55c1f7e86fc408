"""What stands in the record of trust, and its form as JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

SCHEMA = "stiffcal/trust-record/1"
MOST_GENERATIONS = 10_000
Kind: TypeAlias = Literal["plugin", "text", "folder", "place", "generation"]
KINDS: tuple[Kind, ...] = ("plugin", "text", "folder", "place")
"""What the user allows; generations are added by the runs themselves."""

SHA256 = re.compile(r"[0-9a-f]{64}")


class NewerSchemaError(ValueError):
    """The record was written by a newer version of stiffcal."""


@dataclass(frozen=True)
class CommittedGeneration:
    """A generation of a store that a run of this user has written."""

    index_sha256: str
    """Of the store's generation.json, which holds each file's SHA-256."""
    sources_state: str
    """One digest over (name, device, inode, size, mtime_ns, ctime_ns) of every large source file when it was hashed; ""
    where there are none.
    """
    committed: str
    """When, UTC, ISO 8601."""


@dataclass(frozen=True)
class TrustEntry:
    """One entry of the record."""

    kind: Kind
    """What is trusted."""
    key: str
    """The SHA-256, the folder or the place."""
    note: str
    """Where it was when the user allowed it, "" where that is not known."""
    since: str
    """When, UTC, ISO 8601."""


@dataclass
class RecordContent:
    """Everything in the record."""

    allowed: dict[tuple[Kind, str], TrustEntry] = field(default_factory=dict)
    """What the user has allowed, by kind and key."""
    generations: dict[str, CommittedGeneration] = field(default_factory=dict)
    """By the digest of their index, oldest first."""

    def add(self, generations: Iterable[CommittedGeneration]) -> None:
        """Add generations as the newest, and let go of the oldest beyond the most that are kept."""
        for generation in generations:
            self.generations.pop(generation.index_sha256, None)
            self.generations[generation.index_sha256] = generation
        for key in list(self.generations)[: max(0, len(self.generations) - MOST_GENERATIONS)]:
            del self.generations[key]


def to_json(content: RecordContent) -> str:
    """Return the record as text.

    Examples
    --------
    >>> content = RecordContent()
    >>> content.add([CommittedGeneration("a" * 64, "", "2026-01-01T00:00:00Z")])
    >>> from_json(to_json(content)) == content
    True
    """
    allowed: dict[str, list[list[str]]] = {kind: [] for kind in KINDS}
    for entry in content.allowed.values():
        allowed[entry.kind].append([entry.key, entry.note, entry.since])
    rows = [[row.index_sha256, row.sources_state, row.committed] for row in content.generations.values()]
    # a lone surrogate (a folder's name that is no UTF-8) stands as an escape
    return json.dumps({"schema": SCHEMA, **allowed, "generation": rows}, indent=None, separators=(",", ":"))


def from_json(text: str) -> RecordContent:
    """Return the record that a text holds.

    Raises
    ------
    NewerSchemaError : a newer stiffcal wrote it.
    ValueError : it is damaged.
    """
    try:
        document: Any = json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if not isinstance(document, dict) or not isinstance(document.get("schema"), str):
        raise ValueError("no record of trust")
    schema: str = document["schema"]
    if schema != SCHEMA:
        family, _, number = schema.rpartition("/")
        if family == SCHEMA.rpartition("/")[0] and number.isdecimal():
            raise NewerSchemaError(schema)
        raise ValueError(f"unknown schema {schema!r}")
    content = RecordContent()
    for kind in KINDS:
        for key, note, since in _rows(document, kind):
            if kind in ("plugin", "text") and SHA256.fullmatch(key) is None:
                raise ValueError(f"no SHA-256: {key!r}")
            content.allowed[kind, key] = TrustEntry(kind, key, note, since)
    generations = [CommittedGeneration(*row) for row in _rows(document, "generation")]
    if any(SHA256.fullmatch(row.index_sha256) is None for row in generations):
        raise ValueError("a generation without a SHA-256")
    content.add(generations)
    return content


def _rows(document: dict[str, Any], kind: Kind) -> list[list[str]]:
    rows = document.get(kind)
    if not isinstance(rows, list):
        raise ValueError(f"no list of {kind}")
    for row in rows:
        if not isinstance(row, list) or len(row) != 3 or not all(isinstance(text, str) for text in row):
            raise ValueError(f"a damaged entry of {kind}")
    return rows


def lines_of_code(text: str) -> list[str]:
    r"""Return the lines of code as Python splits them: not at the further separators of `str.splitlines`.

    Examples
    --------
    >>> lines_of_code("a = 1\r\nb = 2\n")
    ['a = 1', 'b = 2']
    """
    lines = re.split(r"\r\n|\r|\n", text)
    return lines if lines[-1] else lines[:-1]
