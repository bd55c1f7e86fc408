"""Logs that lie in a campaign and that its manifest does not name: what they seem to be, and lines to copy."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, NamedTuple

from stiffcal.documents import NOT_IN_DOCUMENT
from stiffcal.escapes import toml_text
from stiffcal.propose.explained_column import ExplainedColumn
from stiffcal.propose.lines import FORCE_SENSOR, TOOL, FrameNames, ProposedLine

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign

# Of a wider table the first columns are listed.
MOST_COLUMNS = 200
# So many files of one make are looked into; the others are named by count.
LOOKED_AT = 200
# The frames of a campaign that are taken where a signal needs one, by preference.
BODIES = (TOOL, "target", "tcp")
LOAD_POINTS = (TOOL, "load_point", "target")


@dataclass(frozen=True, slots=True, kw_only=True)
class ProposedSource:
    """Logs in ``raw`` that the manifest does not name."""

    files: list[str]
    """Their names."""
    device: str
    """Whose export they seem to be, "" not known."""
    lines: list[str]
    """Of the manifest, to copy."""
    columns: list[ExplainedColumn]
    """Every column, with what it is taken for and why."""
    understood: Annotated[bool, NOT_IN_DOCUMENT] = True
    """False where the lines are comments on why no signal was found."""


def propose_sources(campaign: Campaign) -> list[ProposedSource]:
    """Return, for every kind of log that nothing names, what it seems to be and the manifest's lines for it.

    Returns
    -------
    list of ProposedSource
    """
    files = _unnamed(campaign)[:LOOKED_AT]
    if not files:
        return []
    taken_names, frames = set(campaign.manifest.sources), set(campaign.manifest.frames)
    groups: dict[tuple[_SniffedLog, ...], list[str]] = {}
    of_runs = _of_known_sources(campaign, files)
    listed = {file for proposal in of_runs for file in proposal.files}
    for file in files:
        if file not in listed:
            groups.setdefault(_sniff(campaign, file, frames), []).append(file)
    return of_runs + [_proposal(log, files, taken_names, frames) for logs, files in groups.items() for log in logs]


def _of_known_sources(campaign: Campaign, files: list[str]) -> list[ProposedSource]:
    """Return the runs of files that sources of the manifest read, once `[[runs]]` lists them."""
    from stiffcal.ingest.quality.unlisted_files import unlisted_runs

    return [
        ProposedSource(files=list(run.files.values()), device="", lines=list(run.lines), columns=[])
        for run in unlisted_runs(campaign, files)
    ]


def _proposal(log: _SniffedLog, files: list[str], taken_names: set[str], frames: set[str]) -> ProposedSource:
    lines = [str(line) for line in log.lines]
    columns = [replace(column, file=files[0]) for column in log.columns]
    if not log.understood:  # a maker's log: why, and what helps
        return ProposedSource(
            files=files,
            device=log.device,
            lines=lines,
            columns=columns,
            understood=False,
        )
    name = next(
        candidate for k in range(1, 100) if (candidate := log.name + (str(k) if k > 1 else "")) not in taken_names
    )
    taken_names.add(name)
    for file in files[:3]:
        lines.append(f"# in its run: {toml_text.pair('files', {name: file})}")
    if len(files) > 3:
        lines.append(f"# … and {len(files) - 3} more files of this kind")
    from stiffcal.propose.log_kind import FRAMES

    needed = {frame for line in log.lines for frame in line.frames} - frames
    missing = [str(line) for frame, frame_lines in FRAMES.items() if frame in needed for line in frame_lines]
    proposed = [f"[sources.{name}]", *lines, *missing]
    return ProposedSource(
        files=files,
        device=log.device,
        lines=proposed,
        columns=columns,
    )


def _frame_names(frames: set[str]) -> FrameNames:
    """Return the frames of the campaign that fit; `TOOL`, which it may lack, where there is none."""
    body, point = (next((name for name in names if name in frames), TOOL) for names in (BODIES, LOAD_POINTS))
    return FrameNames(body, point, FORCE_SENSOR if FORCE_SENSOR in frames else "base")


def _unnamed(campaign: Campaign) -> list[str]:
    from stiffcal.ingest.sources import manifest_data_files

    # of a run that lacks another log it is said which: its files need no source
    incomplete = () if campaign.found is None else campaign.found.unpartnered
    partly = {file for entry in incomplete for file in entry.files.values()}
    named = {*manifest_data_files(campaign), *partly, "raw/README.txt"}  # the template's
    unnamed = []
    for place, folders, names in os.walk(campaign.folder / "raw"):
        above = Path(place).relative_to(campaign.folder).as_posix()
        folders[:] = [name for name in folders if f"{above}/{name}" not in named]  # a log may be a folder
        files = [f"{above}/{name}" for name in names if f"{above}/{name}" not in named]
        unnamed += [file for file in files if (campaign.folder / file).is_file()]
    return sorted(unnamed, key=lambda file: PurePosixPath(file).parts)


class _SniffedLog(NamedTuple):
    """What a log seems to be: its device, a name for its source, the manifest's lines or comments instead of them."""

    device: str
    name: str
    lines: tuple[ProposedLine, ...]
    columns: tuple[ExplainedColumn, ...] = ()
    understood: bool = True


def _sniff(campaign: Campaign, file: str, frames: set[str]) -> tuple[_SniffedLog, ...]:
    """Return what a log seems to be: one entry for each source in it, or one that says why none is understood."""
    from stiffcal.propose.log_kind import log_kind, with_doubt

    names = _frame_names(frames)
    found = []
    kind = log_kind(campaign.folder / file, file, names, chain=campaign.chain)
    for part in (kind, *kind.further):
        lines = part.lines
        if not part.why_not:
            lines = tuple(with_doubt(line, names) if line in part.signals else line for line in lines)
        columns = tuple(replace(column, file="") for column in part.columns[:MOST_COLUMNS])  # alike in all such files
        found.append(_SniffedLog(part.device, part.name, lines, columns, understood=not part.why_not))
    return tuple(found)
