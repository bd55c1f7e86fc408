"""Where results come from: the hash of every source, the settings, the versions of what computed them."""

from __future__ import annotations

import importlib.metadata
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal

from stiffcal.documents import Document
from stiffcal.store.source_files import FileStatuses, SourceFile, hash_files

PACKAGES = ("numpy", "scipy", "pyarrow", "h5py", "pandas", "pydantic")

MOST_NAMED = 6
"""Files of one kind that a message names: those of two runs of three devices."""


@dataclass(frozen=True, kw_only=True)
class IngestSettings:
    """What besides the logs decides what is made of them."""

    manifest: Document
    """campaign.toml, without thresholds, report, trend, effects and name."""
    robot: Document
    """robot.toml."""
    revision: int
    """Of what computes."""


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """What a generation was made from; the store's document ``provenance``."""

    schema: Literal["stiffcal/provenance/1"] = "stiffcal/provenance/1"
    warnings: list[str] = field(default_factory=list)
    """None: there is nothing to warn of."""
    created: str
    """UTC, ISO 8601."""
    command: str
    """The command that made it."""
    sources: tuple[SourceFile, ...]
    """Every file that was read."""
    settings: Document
    """Manifest, robot and whatever else shaped the result, as JSON values."""
    versions: dict[str, str]
    """Of Python, stiffcal and the packages that compute."""

    @classmethod
    def now(cls, command: str, sources: Sequence[SourceFile], settings: Mapping[str, Any]) -> Provenance:
        """Return a record of this moment and these versions."""
        return cls(
            created=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            command=command,
            sources=tuple(sources),
            settings=dict(settings),
            versions=versions(),
        )


@dataclass(frozen=True)
class SourceChanges:
    """How the sources differ from those that were read."""

    changed: tuple[str, ...] = ()
    """Other content than then."""
    missing: tuple[str, ...] = ()
    """In the manifest, not on the disk."""
    new: tuple[str, ...] = ()
    """In the manifest, not read then."""
    dropped: tuple[str, ...] = ()
    """Read then, no longer in the manifest."""
    state: str = ""
    """`FileStatuses.state_of_all` of the large sources that were compared, to be remembered where nothing differs."""

    def __bool__(self) -> bool:
        return bool(self.changed or self.missing or self.new or self.dropped)

    def __str__(self) -> str:
        words = {"changed": "changed", "missing": "missing", "new": "new", "dropped": "no longer named"}
        parts = [f"{word}: {_first_of(getattr(self, kind))}" for kind, word in words.items() if getattr(self, kind)]
        return "; ".join(parts) or "no source changed"


def _first_of(files: Sequence[str]) -> str:
    more = len(files) - MOST_NAMED
    return ", ".join([*files[:MOST_NAMED], *([f"{more} more"] if more > 0 else [])])


def versions() -> dict[str, str]:
    """Return the versions of Python, stiffcal and the packages that compute, without importing them.

    Examples
    --------
    >>> sorted(versions())[:2]
    ['h5py', 'numpy']
    """
    return dict(_package_versions())


@cache
def _package_versions() -> tuple[tuple[str, str], ...]:
    from stiffcal import __version__

    versions = {"python": sys.version.split()[0], "stiffcal": __version__}
    for package in PACKAGES:
        with suppress(importlib.metadata.PackageNotFoundError):
            versions[package] = importlib.metadata.version(package)
    return tuple(versions.items())


def changed_sources(
    provenance: Provenance,
    folder: Path,
    files: Sequence[str] | None = None,
    thorough: bool = False,
    elsewhere: Sequence[SourceFile] = (),
    known_state: str = "",
    states: Callable[[], Mapping[str, str]] = dict,
) -> SourceChanges:
    """Compare the sources on the disk with those that were read.

    Parameters
    ----------
    provenance : the record of what was read.
    folder : the campaign folder.
    files : what the manifest names now; None: the same as then.
    thorough : hash large files too, whatever the file system's data.
    elsewhere : sources that are no files, as they are now.
    known_state : `FileStatuses.state_of_all` when they were last hashed, from the user's own record and not from the
        store; where it is the present one, no large file is hashed.
    states : returns `FileStatus.state` of each file when it was read, from a store of the user's own; one that is the
        present one shows that a large file need not be hashed. Asked only where something has changed.

    Raises
    ------
    InputError : a file cannot be read, or changes meanwhile.
    """
    known = {source.file: source for source in provenance.sources}
    outside = {source.file: source.sha256 for source in elsewhere}
    named = list(dict.fromkeys(files)) if files is not None else list(known)
    statuses = FileStatuses(folder, named)
    there = statuses.of_file
    still = frozenset(named)
    new = [file for file in named if file not in known and file in there]
    new += [name for name in outside if name not in known]
    dropped = [file for file in known if file not in still and file not in outside]
    changed = [name for name, digest in outside.items() if name in known and known[name].sha256 != digest]
    always = statuses.always_compared()
    judged = [file for file in named if file in known and file in there and file not in always]
    if not thorough and known_state != "" and known_state == statuses.state_of_all(judged):
        unchanged, state = frozenset(judged), known_state
    else:
        unchanged = frozenset() if thorough else statuses.unchanged(states()).intersection(judged)
        for file in judged:
            if file not in unchanged:
                statuses.settle(file)
        state = statuses.state_of_all(judged)
    compared = [file for file in named if file in known and file in there and file not in unchanged]
    resized = {file for file in compared if there[file].bytes != known[file].bytes}
    found = {source.file: source for source in hash_files(folder, [file for file in compared if file not in resized])}
    changed += [file for file in compared if file in resized or found[file].sha256 != known[file].sha256]
    if state not in ("", known_state) and state != FileStatuses(folder, judged).state_of_all(judged):
        state = ""  # a source has changed since it was hashed
    missing = [file for file in named if file not in there]
    return SourceChanges(tuple(changed), tuple(missing), tuple(new), tuple(dropped), state)


def changed_settings(provenance: Provenance, settings: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the settings that differ from the recorded ones, as dotted keys.

    Examples
    --------
    >>> then = Provenance.now("ingest", (), {"robot": {"a": 1, "b": [2]}})
    >>> changed_settings(then, {"robot": {"a": 1, "b": [3]}, "name": "x"})
    ('robot.b', 'name')
    """
    return tuple(_differences(provenance.settings, settings, ""))


def _differences(then: Mapping[str, Any], now: Mapping[str, Any], prefix: str) -> Iterator[str]:
    for key in dict.fromkeys((*then, *now)):
        old, new = then.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from _differences(old, new, f"{prefix}{key}.")
        elif old != new or (key in then) != (key in now):
            yield f"{prefix}{key}"
