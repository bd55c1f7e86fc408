"""What ``trust`` answers, typed."""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict


class TrustedEntry(TypedDict):
    """What is trusted: a plugin or a query by its SHA-256, a folder or a place of stores by its name."""

    kind: Literal["plugin", "text", "folder", "place", "generation"]
    key: str
    note: str
    since: str


class PluginFile(TypedDict):
    """A file of a campaign's code; ``effects`` are the names of its effects, found without running it."""

    name: str
    lines: int
    bytes: int
    effects: list[str]
    text: str


class Plugins(TypedDict):
    """All code of a campaign, under one SHA-256 of names and bytes."""

    sha256: str
    trusted: bool
    files: list[PluginFile]


class Query(TypedDict):
    """A text that a campaign sends to a database; ``place`` is where it stands first."""

    sha256: str
    trusted: bool
    place: str
    text: str


class Trust(TypedDict):
    """Answer of ``trust``; ``plugins`` null where the campaign brings no code.

    With ``--list``: ``record`` is the file of the record, null where nothing is remembered, ``generations`` how many
    generations of stores it holds, ``environment`` the hashes in STIFFCAL_TRUST.
    """

    schema: Literal["stiffcal/trust/1"]
    warnings: list[str]
    action: Literal["shown", "allowed", "listed", "revoked"]
    entries: list[TrustedEntry]
    folder: NotRequired[str]
    plugins: NotRequired[Plugins | None]
    queries: NotRequired[list[Query]]
    record: NotRequired[str | None]
    generations: NotRequired[int]
    environment: NotRequired[list[str]]
