"""Files of one pattern: ``raw/{run}_force.csv`` names the log of every run.

``{run}`` stands for the run's name and ``*`` for text that differs and does not count, as a date does; neither reaches
across a folder. `found_runs` applies the patterns of a manifest to the files that are there.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from types import MappingProxyType

from stiffcal.campaign.toml.reach import escapes, leads_outside
from stiffcal.natural_order import NameKey, natural_key

RUN = "{run}"
ANY = "*"
_FREE = re.compile(r"(\{run\}|\*)")
_TOUCHING = re.compile(r"(\{run\}|\*)(\{run\}|\*)")


@dataclass(frozen=True)
class FilePattern:
    """A path, relative to the campaign folder, with `RUN` in it.

    Examples
    --------
    >>> pattern = FilePattern("raw/*_tracker_{run}.txt")
    >>> pattern.run_of("raw/2026-11-20_101530_tracker_P3.txt"), pattern.run_of("raw/old/1_tracker_P3.txt")
    ('P3', None)
    >>> pattern.file_of("P4")
    'raw/*_tracker_P4.txt'
    """

    text: str
    """As written."""

    @property
    def fault(self) -> tuple[str, str] | None:
        """Why the pattern means nothing, and the mend; None where it does."""
        touching = _TOUCHING.search(self.text)
        if touching is not None:
            reason = f"nothing separates {touching[1]} from {touching[2]}"
            return reason, "write the text that stands between them in the names of the files"
        return None

    @property
    def fixed(self) -> int:
        """How many characters are the same in the names of all files."""
        return len(_FREE.sub("", self.text))

    @cached_property
    def parts(self) -> tuple[str, ...]:
        """The names of folders on the way, and of the file."""
        return tuple(part for part in self.text.replace("\\", "/").split("/") if part not in ("", "."))

    @cached_property
    def _expression(self) -> re.Pattern[str]:
        pieces, named = [], False
        for piece in _FREE.split("/".join(self.parts)):
            if piece == RUN:
                pieces.append("(?P=run)" if named else "(?P<run>[^/]+)")
                named = True
            else:
                # as few characters as possible: the name is then what follows the first separator
                pieces.append("[^/]*?" if piece == ANY else re.escape(piece))
        return re.compile("".join(pieces), re.DOTALL)

    def run_of(self, file: str) -> str | None:
        """Return the name of the run whose log a file is, None where the pattern does not match."""
        match = self._expression.fullmatch(file)
        name = match["run"] if match is not None else None
        return None if name in (".", "..") else name

    def file_of(self, run: str) -> str:
        """Return the path that is expected for a run, with `ANY` where that differs."""
        return self.text.replace(RUN, run)

    def files(self, folder: Path) -> Iterator[tuple[str, str]]:
        """Yield (file, run) of every file that matches, in no order.

        Hidden files, and what a link outside the campaign folder leads to, are not looked at.
        """
        if not escapes(self.text):
            for file in self._below(folder, (), self.parts):
                name = self.run_of(file)
                if name is not None:
                    yield file, name

    def _below(self, folder: Path, above: tuple[str, ...], parts: tuple[str, ...]) -> Iterator[str]:
        part, rest = parts[0], parts[1:]
        here = "/".join(above)
        if not _FREE.search(part):
            names: Iterable[str] = [part] if rest or (folder / here / part).exists() else []
        elif leads_outside(folder, here) is not None:
            return  # opening a file there reports the link
        else:
            names = _matching(folder / here, part, folders=bool(rest))
        for name in names:
            if rest:
                yield from self._below(folder, (*above, name), rest)
            else:
                yield "/".join((*above, name))


def _matching(place: Path, part: str, *, folders: bool) -> list[str]:
    """Return the names in a folder that one part of a pattern matches; of folders, or of anything."""
    expression = _part_expression(part)
    try:
        with os.scandir(place) as entries:
            return [
                entry.name
                for entry in entries
                if expression.fullmatch(entry.name)
                and (part.startswith(".") or not entry.name.startswith("."))
                and (not folders or entry.is_dir())
            ]
    except OSError:  # no such folder, no right to list it: no file is found there
        return []


@lru_cache(maxsize=256)
def _part_expression(part: str) -> re.Pattern[str]:
    pieces = (".*" if piece in (RUN, ANY) else re.escape(piece) for piece in _FREE.split(part))
    return re.compile("".join(pieces), re.DOTALL)


def lacking_sources(patterns: Iterable[str], files: Iterable[str], instead: Mapping[str, str]) -> tuple[str, ...]:
    """Return the sources without a file, of those that stand in for each other the first.

    Parameters
    ----------
    patterns : the sources with a pattern. files : those that have a file. instead : as of `files_of_runs`.
    """
    present = {instead.get(source, source) for source in files}
    wanted = dict.fromkeys(instead.get(source, source) for source in patterns)
    return tuple(source for source in wanted if source not in present)


@dataclass(frozen=True)
class Unpartnered:
    """A name that some sources have a file of, and others have not: no run yet."""

    run: str
    """The name."""
    files: Mapping[str, str]
    """The file of each source that has one."""
    lacking: tuple[str, ...]
    """The sources that have none; of sources that stand in for each other the first."""


@dataclass(frozen=True)
class Ambiguous:
    """Two files of one run and source."""

    run: str
    source: str
    files: tuple[str, str]
    """The first two."""


@dataclass(frozen=True)
class FoundFiles:
    """What the patterns of a manifest match."""

    runs: Mapping[str, Mapping[str, str]]
    """The files of each run, by source, in the natural order of the runs' names."""
    unpartnered: tuple[Unpartnered, ...]
    ambiguous: tuple[Ambiguous, ...]


def found_files(
    folder: Path,
    patterns: Mapping[str, FilePattern],
    named: frozenset[str],
    instead: Mapping[str, str] = MappingProxyType({}),
) -> FoundFiles:
    """Return the runs that the files in a folder make by the patterns of its sources.

    Parameters
    ----------
    folder : the campaign folder.
    patterns : of each source that has one.
    named : files that a run names itself: they are not matched again.
    instead : source to the first of those that stand in for each other.
    """
    matches = {
        source: [match for match in pattern.files(folder) if match[0] not in named]
        for source, pattern in patterns.items()
    }
    return files_of_runs(matches, patterns, instead)


def files_of_runs(
    matches: Mapping[str, Sequence[tuple[str, str]]],
    patterns: Mapping[str, FilePattern],
    instead: Mapping[str, str] = MappingProxyType({}),
) -> FoundFiles:
    """Return the runs that files make.

    Parameters
    ----------
    matches : of each source (file, name of the run) of the files that its pattern matches.
    patterns : of each source.
    instead : source to the first of those that stand in for each other: a run is complete with a file of one of them.

    Notes
    -----
    A file that the patterns of several sources match belongs to those with the most fixed characters. Names that
    differ in leading zeros alone are one run, called as the first source's file calls it.
    """
    longest: dict[str, int] = {}
    for source, pairs in matches.items():
        for file, _ in pairs:
            longest[file] = max(longest.get(file, 0), patterns[source].fixed)
    names: dict[NameKey, str] = {}
    by_name: dict[str, dict[str, str]] = {}
    ambiguous: list[Ambiguous] = []
    for source, pairs in matches.items():
        for file, name in sorted(pairs):
            if patterns[source].fixed < longest[file]:
                continue
            files = by_name.setdefault(names.setdefault(natural_key(name), name), {})
            if source in files:
                ambiguous.append(Ambiguous(names[natural_key(name)], source, (files[source], file)))
            files.setdefault(source, file)
    runs: dict[str, Mapping[str, str]] = {}
    unpartnered: list[Unpartnered] = []
    for name in sorted(by_name, key=lambda name: (natural_key(name), name)):
        lacking = lacking_sources(patterns, by_name[name], instead)
        if lacking:
            unpartnered.append(Unpartnered(name, by_name[name], lacking))
        else:
            runs[name] = by_name[name]
    return FoundFiles(runs, tuple(unpartnered), tuple(ambiguous))
