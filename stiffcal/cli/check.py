"""`stiffcal check`: what was understood of the campaign, and what is still missing."""

from __future__ import annotations

import itertools
import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.clocks import clock_rates
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.next_step import after_check, lacks_load
from stiffcal.cli.options import HERE, AsJson, Details, Folder, StoreAt
from stiffcal.cli.registration import show_registration
from stiffcal.cli.suspects import show_suspects
from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import show_verdict
from stiffcal.cli.wording import NOT_KNOWN, angle, length, significant
from stiffcal.wording import count

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.ingest.checks.results import CheckedColumn, CheckedJoint, CheckedRun, CheckedSource, CheckResult

READ_AS = {
    **dict.fromkeys(("deg", "rad", "gon", "mrad", "rev", "arcmin", "arcsec"), (180.0 / math.pi, "°")),
    **dict.fromkeys(("m", "mm", "um", "cm", "in", "inch"), (1e3, "mm")),
    **dict.fromkeys(("N", "kN", "mN", "uN", "daN", "kgf", "lbf"), (1.0, "N")),
    **dict.fromkeys(("N*m", "N*mm", "kN*m"), (1.0, "N·m")),
    **dict.fromkeys(("degC", "degF"), (1.0, "°C")),
    **dict.fromkeys(("deg/s", "rad/s", "mrad/s", "rev/s", "rpm"), (1.0, "rad/s")),
    **dict.fromkeys(("A", "mA"), (1.0, "A")),
}
"""Unit in the log to (factor from SI, unit) in which ranges are read; rotations as angles."""


MOST_FILES = 20
MOST_RUNS = 8
"""Rows of runs without details."""
REPORT_ASKED = (
    "whose robot is it? Page 1 of the report states serial_number, site, operator, measured, temperature and "
    "instruments of [report] in campaign.toml; an empty [report] ends this question"
)


def check(
    folder: Folder = HERE,
    quick: Annotated[bool, typer.Option("--quick", help="Read only the first lines of each file.")] = False,
    run: Annotated[str | None, typer.Option(metavar="ID", help="Only this run.", show_default=False)] = None,
    details: Details = False,
    as_json: AsJson = False,
    store: StoreAt = None,
) -> int:
    """Check the folder: what was read, what is missing.

    Reads all logs and lists every fault with its place; useful already during the measurement. Exit code 1 if the
    campaign is not ready.

    Example: stiffcal check demo --quick
    """
    with answering(as_json) as answer:
        from stiffcal.ingest.checks.loaded import check_campaign

        result = check_campaign(folder, quick=quick, run=run, progress=answer.progress)
        answer.give(result, partial(show_check, details=details), after_check(folder, result, store))
    return OK if result.ready else NOT_HELD


def show_check(console: AnswerConsole, result: CheckResult, details: bool = False) -> None:
    """Draw whether the campaign is ready, then what was understood: sources, ranges, runs, kinematics, joints.

    Parameters
    ----------
    details : a row for each column and run; else one for each signal, and for runs that are alike.
    """
    show_verdict(console, "pass" if result.ready else "fail", "ready" if result.ready else "not ready:")
    for line in () if result.ready else result.missing:
        console.print(f"  {line}", soft_wrap=True)
    if not result.ready:
        console.print(f"to do: {_to_do(result)}", soft_wrap=True)
    console.show_warnings(result.warnings)
    show_registration(console, result.registration)
    _show_sources(console, result.sources)
    _show_ranges(console, result.sources, details)
    _show_runs(console, result.runs, details)
    for line in clock_rates(run.clock_ahead_s for run in result.runs):
        console.print(line, soft_wrap=True)
    kinematics = result.kinematics
    if kinematics is not None and kinematics.median_m is not None:
        turned = kinematics.orientation_rad
        text = f"kinematics and tracker agree within {length(kinematics.median_m)} (median)"
        text += f", {length(kinematics.worst_m)} (worst)" if kinematics.worst_m is not None else ""
        console.print(text + (f", {angle(turned)} rotation" if turned is not None else ""))
    if result.noise is not None:
        console.print(result.noise.says, soft_wrap=True)
    _show_joints(console, result.joints or [])
    show_suspects(console, result.suspects, result.suspects_not_checked if details else None)
    for view in result.rods or []:
        for sentence in view.says:
            console.print(sentence, soft_wrap=True)
    for proposal in result.proposals or []:
        for file in proposal.files[:MOST_FILES]:
            by = f", probably by: {proposal.device}" if proposal.device else ""
            console.print(f"{file}: no source of campaign.toml reads it{by}", soft_wrap=True)
        if len(proposal.files) > MOST_FILES:
            console.print(f"and {len(proposal.files) - MOST_FILES} more files like these", soft_wrap=True)
        for line in proposal.lines:
            console.print(f"  {line}", soft_wrap=True, markup=False, highlight=False)
    if details and result.observability is not None:
        indices = result.observability
        values = ((f"O{number}", getattr(indices, f"O{number}")) for number in range(1, 6))
        text = ", ".join(f"{name} {significant(value)}" for name, value in values)
        where = f"observability indices of the {indices.n_parameters} parameters in these {indices.n_poses} poses"
        console.print(f"{where}, larger is better: {text}", soft_wrap=True)
    if result.ready and not result.states_report and console.is_terminal:
        console.print(REPORT_ASKED)


def _to_do(result: CheckResult) -> str:
    """Return what makes the campaign ready."""
    if lacks_load(result):
        return "measure these joints under other loads or poses, which plan proposes (or go on without them: run)"
    return "add or correct what is listed, then check again"


def _by_source(files: list[CheckedSource]) -> dict[str, list[CheckedSource]]:
    grouped: dict[str, list[CheckedSource]] = {}
    for file in files:
        grouped.setdefault(file.source, []).append(file)
    return grouped


def _show_sources(console: AnswerConsole, files: list[CheckedSource]) -> None:
    if not files:
        return
    table = plain_table("source", "files>", "rows>", "rate [1/s]>", "span [s]>", "longest gap [s]>")
    for source, source_files in _by_source(files).items():
        rows = sum(file.rows for file in source_files)
        sampled = [file for file in source_files if file.sampled]
        ranges = _range([file.rate_hz for file in sampled]), _range([file.span_s for file in sampled])
        gaps = [file.longest_gap_s for file in sampled if file.longest_gap_s is not None]
        table.add_row(source, str(len(source_files)), str(rows), *ranges, significant(max(gaps)) if gaps else NOT_KNOWN)
    console.print(table)


def _range(values: list[float | None], digits: int = 4) -> str:
    known = [value for value in values if value is not None]
    if not known:
        return NOT_KNOWN
    low, high = significant(min(known), digits), significant(max(known), digits)
    return low if low == high else f"{low} … {high}"


def _show_ranges(console: AnswerConsole, files: list[CheckedSource], details: bool) -> None:
    """Draw the range of each column, or of all of a signal, over all files of its source, in the units people read."""
    table = plain_table("source", "signal", "column", "written in", "lowest>", "highest>", "", "moved")
    for source, source_files in _by_source(files).items():
        columns: dict[tuple[str, str, str], list[CheckedColumn]] = {}
        for file in source_files:
            for column in file.columns:
                # a joint is a thing of its own, and may stand in the column of another
                own = column.column if details or column.signal == "joints" else ""
                columns.setdefault((column.signal, column.unit, own), []).append(column)
        for (signal, written, _), ranges in columns.items():
            names = list(dict.fromkeys(one.column for one in ranges))
            low = min((one.low_si for one in ranges if one.low_si is not None), default=None)
            high = max((one.high_si for one in ranges if one.high_si is not None), default=None)
            factor, unit = READ_AS.get(written, (1.0, written))
            zero = 273.15 if unit == "°C" else 0.0
            ends = (NOT_KNOWN if end is None else significant(end * factor - zero, 4) for end in (low, high))
            name = names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}"
            table.add_row(source, signal, name, written, *ends, unit, _moved(names, ranges))
    if table.row_count:
        console.print(table)


def _moved(names: list[str], ranges: list[CheckedColumn]) -> str:
    """Return which columns moved, and of one in how many files."""
    if len(names) == 1:
        count = sum(bool(one.moved) for one in ranges)
        return "no" if not count else "yes" if count == len(ranges) else f"in {count} of {len(ranges)} files"
    still = [name for name in names if not any(one.moved for one in ranges if one.column == name)]
    return "yes" if not still else "no" if len(still) == len(names) else f"not {', '.join(still)}"


def _show_runs(console: AnswerConsole, runs: list[CheckedRun], details: bool) -> None:
    """Draw a row for each run; without details one for neighbours of a kind and as many states, of some of them."""
    if not runs:
        return
    table = plain_table("run", "experiment", "states>", "set aside>", "largest force [N]>")

    def cells(run: CheckedRun) -> tuple[str, str, str, str]:
        size = f"{run.n_readings} readings" if run.n_readings else str(run.n_states)
        return run.experiment, size, str(len(run.set_aside)), run.id if details else ""

    alike = [(key, list(same)) for key, same in itertools.groupby(runs, cells)]
    most = len(runs) if details else MOST_RUNS
    for key, same in alike[:most]:
        few = ", ".join(run.id for run in same)
        name = few if len(same) < 3 else f"{same[0].id} … {same[-1].id}: {len(same)} runs"
        table.add_row(name, *key[:3], _range([run.largest_force_N for run in same], 3))
    console.print(table)
    if len(alike) > most:
        console.print(f"  and {count(sum(len(same) for _, same in alike[most:]), 'more run')} (--details)")
    for line in [f"run {run.id}, {line}" for run in runs for line in run.set_aside][:most]:
        console.print(f"set aside: {line}", soft_wrap=True)


def _show_joints(console: AnswerConsole, joints: list[CheckedJoint]) -> None:
    if not joints:
        return
    table = plain_table("joint", "largest torque [N·m]>", "its stiffness")
    for joint in joints:
        unit = " N" if joint.prismatic else ""
        largest = joint.largest_torque_Nm
        # below the last digit of any torque sensor it is rounding of a torque that is zero
        shown = 0.0 if largest is not None and largest < 1e-6 else largest
        table.add_row(joint.joint, f"{significant(shown)}{unit}", joint.says)
    console.print(table)
