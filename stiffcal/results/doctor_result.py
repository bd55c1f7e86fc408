"""What `doctor` answers: the libraries of this machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from stiffcal.documents import CommandResult


@dataclass(frozen=True, slots=True, kw_only=True)
class LibraryStatus:
    """A library that stiffcal uses."""

    name: str
    """As pip knows it."""
    required: str
    """The versions that stiffcal works with."""
    version: str | None
    """The installed version; null: not installed."""
    extra: str
    """The extra that it belongs to; empty: stiffcal does not run without it."""
    purpose: str
    """What the extra is for."""
    install: str
    """The command that installs it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DoctorResult(CommandResult):
    """Answer of ``doctor``."""

    schema: Literal["stiffcal/doctor/1"] = "stiffcal/doctor/1"
    version: str
    """Of stiffcal."""
    python: str
    """Version of Python."""
    platform: str
    """Operating system and processor."""
    complete: bool
    """Whether every library without which stiffcal does not run is installed."""
    libraries: list[LibraryStatus]
    """Those without which stiffcal does not run, then those of the extras."""
    formats: list[str]
    """The formats of logs that are read, those whose library is missing included."""
    plugins: list[str]
    """Effects and log formats of other installed packages."""
    state_folder: str | None
    """Where the record of trust is kept; null: the system names no such folder."""
    state_fault: str
    """Why that folder cannot be used; empty: it can."""
