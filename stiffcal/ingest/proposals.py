"""Logs that lie in a campaign and that its manifest does not name: what they seem to be, and lines to copy.

The usual exports are known by words in their first lines: ATI's force-torque sensors, Beckhoff's TwinCAT Scope,
trackers of API, FARO, Leica and Nikon, traces of robot controllers. A column is guessed by its name; every guess is
marked with ``# ?``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from stiffcal.campaign.file_formats import format_of
from stiffcal.documents import NOT_IN_DOCUMENT
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.files import open_regular
from stiffcal.propose.lines import (
    FORCE_SENSOR,
    TOOL,
    TRACKER,
    FrameNames,
    ProposedLine,
    signal_lines,
)

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.propose.table_sniffing import SniffedTable

FIRST_BYTES = 1 << 14
# So many files of one make are looked into; the others are named by count.
LOOKED_AT = 200

# Words of a maker in the name or the first lines, what it is called here, and the name of the source.
MAKERS: tuple[tuple[str, str, str], ...] = (
    (r"\bATI\b|Net ?F/?T|RDT ?Sequence|F/T ?Sequence|Counts per Unit (Force|Torque)", "ATI force-torque sensor", "ft"),
    (r"TwinCAT|Beckhoff|SampleTime ?\[|Starttime of export|\.svdx?\b", "Beckhoff TwinCAT Scope", "scope"),
    (r"\bFARO\b|\bVantage\b|\bCAM2\b", "FARO tracker", "tracker"),
    (r"\bAPI\b.{0,40}(tracker|Radian|OT2|T3)|\bRadian (Pro|Plus|Core)\b|Automated Precision", "API tracker", "tracker"),
    (r"\bLeica\b|Spatial ?Analyzer|\bAT9[36]0\b|T-?Mac\b|T-?Probe\b|Tracker Pilot", "Leica tracker", "tracker"),
    (r"\bNikon\b|\bMetris\b|K-?Series|\bK[46]\d0\b|\biGPS\b|Space ?Probe", "Nikon tracker", "tracker"),
    (r"\bKUKA\b|\bKRC\d?\b|\$(AXIS|POS|TORQUE)_ACT|AxisPos", "KUKA controller trace", "controller"),
    (r"\bABB\b|RobotStudio|Test ?Signal Viewer|\bIRC5\b", "ABB controller trace", "controller"),
    (r"\bFANUC\b|\bSt(ä|ae|a)ubli\b|\bYaskawa\b|\bMotoman\b|\bUR1?\d\b", "robot controller trace", "controller"),
)
# The frames that proposed signals are in, where the campaign has none of the name.
FRAMES: dict[str, tuple[ProposedLine, ...]] = {
    FORCE_SENSOR: (
        *(ProposedLine(f"[frames.{FORCE_SENSOR}]"), ProposedLine('parent = "flange"')),
        ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "position and rotation of the sensor"),
    ),
    TRACKER: (
        *(ProposedLine(f"[frames.{TRACKER}]"), ProposedLine('parent = "base"')),
        ProposedLine("estimate = true", "found from the unloaded poses; or give xyz_m and a rotation"),
    ),
    TOOL: (
        *(ProposedLine(f"[frames.{TOOL}]"), ProposedLine('parent = "flange"')),
        ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "position of the target"),
    ),
}
# The frames of a campaign that are taken where a signal needs one, by preference.
BODIES = (TOOL, "target", "tcp")
LOAD_POINTS = (TOOL, "load_point", "target")
# Repetitions are bounded: these are searched in a log's first lines, which anybody may have written
_NUMBER = r"[^0-9\n]{0,30}([0-9]{1,30}(?:[.,][0-9]{1,30})?)"
_RATE = re.compile(
    r"(?:sampl\w{0,12}[ _-]?rate|data ?rate|abtastrate|frequenc\w{0,12}|frequenz)" + _NUMBER, re.IGNORECASE
)
_PERIOD = re.compile(r"(?:sample ?time|abtastzeit|cycle ?time)\s{0,9}\[?\s{0,9}(ms|us|s)\]?" + _NUMBER, re.IGNORECASE)
_LARGEST_FORCE = 1e5
_COUNTS = re.compile(r"counts per (?:unit )?(force|torque)" + _NUMBER, re.IGNORECASE)
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
_FROM_HEADER = "as stated in its first lines"


@dataclass(frozen=True, slots=True, kw_only=True)
class ProposedSource:
    """Logs in ``raw`` that the manifest does not name."""

    files: list[str]
    """Their names."""
    device: str
    """Whose export they seem to be, "" not known."""
    lines: list[str]
    """Of the manifest, to copy."""
    understood: Annotated[bool, NOT_IN_DOCUMENT] = True
    """False where the lines are comments on why no signal was found."""


def propose_sources(campaign: Campaign) -> list[ProposedSource]:
    """Return, for every kind of log that nothing names, what it seems to be and the manifest's lines for it.

    Returns
    -------
    list of ProposedSource
    """
    taken_names, frames = set(campaign.manifest.sources), set(campaign.manifest.frames)
    groups: dict[_SniffedLog, list[str]] = {}
    for file in _unnamed(campaign)[:LOOKED_AT]:
        sniffed = _sniff(campaign.folder, file, frames)
        if sniffed is not None:
            groups.setdefault(sniffed, []).append(file)
    return [_proposal(log, files, taken_names, frames) for log, files in groups.items()]


def _proposal(log: _SniffedLog, files: list[str], taken_names: set[str], frames: set[str]) -> ProposedSource:
    lines = [str(line) for line in log.lines]
    if not log.understood:  # a maker's log: why, and what helps
        return ProposedSource(files=files, device=log.device, lines=lines, understood=False)
    name = next(
        candidate for k in range(1, 100) if (candidate := log.name + (str(k) if k > 1 else "")) not in taken_names
    )
    taken_names.add(name)
    for file in files[:3]:
        lines.append(f"# in its run: {toml_text.pair('files', {name: file})}")
    if len(files) > 3:
        lines.append(f"# … and {len(files) - 3} more files of this kind")
    needed = {frame for line in log.lines for frame in line.frames} - frames
    missing = [str(line) for frame, frame_lines in FRAMES.items() if frame in needed for line in frame_lines]
    return ProposedSource(files=files, device=log.device, lines=[f"[sources.{name}]", *lines, *missing])


def _frame_names(frames: set[str]) -> FrameNames:
    """Return the frames of the campaign that fit; `TOOL`, which it may lack, where there is none."""
    body, point = (next((name for name in names if name in frames), TOOL) for names in (BODIES, LOAD_POINTS))
    return FrameNames(body, point)


def _with_doubt(line: ProposedLine, names: FrameNames) -> ProposedLine:
    """Mark a line that names a frame which was taken for want of one called `TOOL`."""
    taken = [name for name in (names.body, names.point) if name != TOOL and name in line.frames]
    return replace(line, doubt=f"or another frame than {taken[0]!r}") if taken and line.doubt is None else line


def _unnamed(campaign: Campaign) -> list[str]:
    from stiffcal.ingest.sources import manifest_data_files

    named = set(manifest_data_files(campaign))
    raw = campaign.folder / "raw"
    unnamed = []
    for path in sorted(raw.rglob("*")) if raw.is_dir() else []:
        file = path.relative_to(campaign.folder).as_posix()
        inside = any(file.startswith(f"{name}/") for name in named)
        if path.is_file() and file not in named and not inside and format_of(file) is not None:
            unnamed.append(file)
    return unnamed


class _SniffedLog(NamedTuple):
    """What a log seems to be: its device, a name for its source, the manifest's lines or comments instead of them."""

    device: str
    name: str
    lines: tuple[ProposedLine, ...]
    understood: bool = True


def _not_understood(device: str, name: str, why: str) -> _SniffedLog | None:
    """Return a log of a known maker with a comment on why no signal is found; None where the maker is not known."""
    return _SniffedLog(device, name, (ProposedLine(f"# {why}"),), understood=False) if device else None


def _sniff(folder: Path, file: str, frames: set[str]) -> _SniffedLog | None:
    """Return the guessed kind of a log, or None where neither device nor signals are understood."""
    path, kind = folder / file, format_of(file)
    text = _first_bytes(path).decode("latin-1")
    device, name = _maker(path.name.replace("_", " ") + "\n" + (text if kind == "csv" else ""))
    try:
        table, layout_lines = _text_table(path) if kind == "csv" else _other_table(folder, file, str(kind))
    except InputError as error:
        return _not_understood(device, name, f"{error.reason}: {error.mend}")
    from stiffcal.propose.column_roles import recognise

    roles, names = recognise(table.columns), _frame_names(frames)
    signals = [_with_doubt(line, names) for line in signal_lines(roles, names)]
    if not signals:
        headers = ", ".join(column.header for column in table.columns[:12])
        mend = "export it with one header line, one time column and names like A1 … A6, Fx, X"
        return _not_understood(device, name, f"no signal recognised in its columns ({headers}): {mend}")
    if not name:
        name = "ft" if roles.force is not None else "tracker" if roles.position is not None else "controller"
    counts = _COUNTS.search(text)
    force = max((column.size for column in roles.force.columns), default=0.0) if roles.force is not None else 0.0
    if counts is not None and force > _LARGEST_FORCE:
        doubt = f"up to {force:.3g}: counts, {counts[2]} per unit? Log or write units, not counts"
        signals.append(ProposedLine("", doubt))
    layout = [ProposedLine(line) for line in (toml_text.pair("format", str(kind)), *layout_lines, 'sampling = "time"')]
    return _SniffedLog(device, name, (*layout, _time_line(table, text), *signals))


def _first_bytes(path: Path) -> bytes:
    try:
        with open_regular(path) as file:
            return file.read(FIRST_BYTES)
    except (OSError, InputError):
        return b""


def _maker(text: str) -> tuple[str, str]:
    for words, device, name in MAKERS:
        if re.search(words, text):
            return device, name
    return "", ""


def _text_table(path: Path) -> tuple[SniffedTable, list[str]]:
    from stiffcal.propose.table_sniffing import sniff_table

    table = sniff_table(path)
    options = ", ".join(f"{key} = {toml_text.value(value)}" for key, value in table.options.items())
    return table, [f"csv = {{ {options} }}"] if options else []


def _other_table(folder: Path, file: str, log_format: str) -> tuple[SniffedTable, list[str]]:
    """Return the columns that a file of another format names itself."""
    from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
    from stiffcal.readers import find_reader

    header = find_reader(folder / file, log_format, file).read_header(folder / file, {}, file)
    columns = tuple(SniffedColumn(name, name, header.units.get(name), (0.0,)) for name in header.columns)
    return SniffedTable(folder / file, columns, header.n_rows or 0, {}), []


def _time_line(table: SniffedTable, text: str) -> ProposedLine:
    from stiffcal.propose.column_roles import recognise

    time = recognise(table.columns).time
    if time is not None:
        known = time.unit in (*_SECONDS, "ns", "iso8601")
        column = {"column": time.header, "unit": (time.unit or "s") if known else "s"}
        return ProposedLine(toml_text.pair("time", column), None if known else "seconds")
    if (rate := _RATE.search(text)) is not None:
        return _rate_line(float(rate[1].replace(",", ".")), _FROM_HEADER)
    if (period := _PERIOD.search(text)) is not None:
        step = float(period[2].replace(",", ".")) * _SECONDS[period[1].lower()]
        if step > 0:
            return _rate_line(1.0 / step, _FROM_HEADER)
    return _rate_line(1000.0, "no time column recognised: write the logging rate")


def _rate_line(hertz: float, doubt: str) -> ProposedLine:
    return ProposedLine(f"time = {{ rate_hz = {hertz:g} }}", doubt)
