"""What `trust` answers: what a campaign folder wants to run, and what the user has allowed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.documents import CommandResult, KeyIf, OrAbsent


@dataclass(frozen=True, slots=True, kw_only=True)
class TrustedItem:
    """Something that the user trusts."""

    kind: Literal["plugin", "text", "folder", "place", "generation"]
    """Text: a query to a database."""
    key: str
    """The SHA-256 of a plugin, a query or a generation; the name of a folder or a place of stores."""
    note: str
    """Where it was when the user allowed it, "" where that is of no use."""
    since: str
    """When that was, UTC, ISO 8601."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CodeFile:
    """A file of a campaign's code."""

    name: str
    """As in the manifest."""
    lines: int
    """How many there are."""
    bytes: int
    """Its size."""
    effects: list[str]
    """Names of its effects, found without running it."""
    text: str
    """All of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignCode:
    """All code of a campaign."""

    sha256: str
    """Of names and bytes of all its files."""
    trusted: bool
    """Whether the user has allowed it."""
    files: list[CodeFile]


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignQuery:
    """A text that a campaign sends to a database."""

    sha256: str
    """Of the text."""
    trusted: bool
    """Whether the user has allowed it."""
    place: str
    """Where it stands first."""
    text: str
    """All of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrustResult(CommandResult):
    """Answer of ``trust``."""

    schema: Literal["stiffcal/trust/1"] = "stiffcal/trust/1"
    action: Literal["shown", "allowed", "listed", "revoked"]
    """What was done."""
    entries: list[TrustedItem]
    """Of the record: what was allowed, listed or revoked."""
    folder: OrAbsent[str] = None
    """The campaign folder that was read."""
    plugins: Annotated[CampaignCode | None, KeyIf("is_of_campaign")] = None
    """Its code, null where it brings none."""
    queries: OrAbsent[list[CampaignQuery]] = None
    """What it sends to a database."""
    record: Annotated[str | None, KeyIf("is_list")] = None
    """The file of the record, null where nothing is remembered."""
    generations: OrAbsent[int] = None
    """How many generations of stores the record holds."""
    environment: OrAbsent[list[str]] = None
    """The hashes in STIFFCAL_TRUST."""

    @property
    def is_of_campaign(self) -> bool:
        """Whether a campaign folder was read."""
        return self.folder is not None

    @property
    def is_list(self) -> bool:
        """Whether everything that is trusted is listed."""
        return self.action == "listed"
