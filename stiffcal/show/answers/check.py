"""What `check` shows: whether the campaign is ready, what was understood of it, what is still missing."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from stiffcal.quantities import si_unit
from stiffcal.quantity import JOINT_ANGLE, TEMPERATURE, ShownUnit, quantity_of
from stiffcal.show import parts
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import DASH, angle, count, length, significant

if TYPE_CHECKING:
    from stiffcal.ingest.checks.results import CheckedColumn, CheckedJoint, CheckedRun, CheckedSource, CheckResult
    from stiffcal.presentation.values import Page
    from stiffcal.show.options import ShowOptions

MOST_FILES = 20
MOST_RUNS = 8
"""Rows of runs without details."""
REPORT_ASKED = (
    "whose robot is it? Page 1 of the report states serial_number, site, operator, measured, temperature and "
    "instruments of [report] in campaign.toml; an empty [report] ends this question"
)


def page(result: CheckResult, options: ShowOptions) -> Page:
    """Return whether the campaign is ready, then what was understood: sources, ranges, runs, kinematics, joints.

    With details there is a row for each column and run; else one for each signal, and for runs that are alike.
    """
    made = PageBuilder("Check of the campaign")
    made.say("ready" if result.ready else "not ready:", "verdict", "pass" if result.ready else "fail")
    for line in () if result.ready else result.missing:
        made.say(f"  {line}", "missing")
    if not result.ready:
        made.say(f"to do: {_to_do(result)}", "to-do")
    made.add(parts.registration(result.registration))
    _add_sources(made, result.sources)
    _add_ranges(made, result.sources, options.details)
    _add_runs(made, result.runs, options.details)
    made.add(parts.clock_rates(run.clock_ahead_s for run in result.runs))
    kinematics = result.kinematics
    if kinematics is not None and kinematics.median_m is not None:
        turned = kinematics.orientation_rad
        text = f"kinematics and tracker agree within {length(kinematics.median_m)} (median)"
        text += f", {length(kinematics.worst_m)} (worst)" if kinematics.worst_m is not None else ""
        made.say(text + (f", {angle(turned)} rotation" if turned is not None else ""), "kinematics")
    if result.noise is not None:
        made.say(result.noise.says, "noise")
    _add_joints(made, result.joints or [])
    made.add(parts.suspects(result.suspects, result.suspects_not_checked if options.details else None))
    for sentence in (sentence for view in result.rods or [] for sentence in view.says):
        made.say(sentence, "rods")
    _add_proposals(made, result)
    if options.details and result.observability is not None:
        indices = result.observability
        values = ((f"O{k}", getattr(indices, f"O{k}")) for k in range(1, 6))
        text = ", ".join(f"{name} {significant(value)}" for name, value in values)
        where = f"observability indices of the {indices.n_parameters} parameters in these {indices.n_poses} poses"
        made.say(f"{where}, larger is better: {text}", "observability")
    if result.ready and not result.states_report:
        made.say(REPORT_ASKED, "report-asked", "question")
    return made.page()


def _add_proposals(made: PageBuilder, result: CheckResult) -> None:
    """Add files that no source reads, with the lines that would read them."""
    for proposal in result.proposals or []:
        by = f", probably by: {proposal.device}" if proposal.device else ""
        for file in proposal.files[:MOST_FILES]:
            made.say(f"{file}: no source of campaign.toml reads it{by}", "not-read")
        if len(proposal.files) > MOST_FILES:
            made.say(f"and {len(proposal.files) - MOST_FILES} more files like these", "not-read")
        for line in proposal.lines:
            made.say(f"  {line}", "proposed-line")


def lacks_load(result: CheckResult) -> bool:
    """Return whether nothing is missing but loads that identify some joints."""
    from stiffcal.reduction.loads.excitation import NOT_KNOWN

    spreads = [joint.expected_relative_std for joint in result.joints or []]
    lacking = [spread for spread in spreads if spread is None or spread > NOT_KNOWN]
    return bool(lacking) and len(result.missing) == len(lacking)


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


def _add_sources(made: PageBuilder, files: list[CheckedSource]) -> None:
    rows = []
    for source, source_files in _by_source(files).items():
        n_rows = sum(file.rows for file in source_files)
        sampled = [file for file in source_files if file.sampled]
        ranges = _range([file.rate_hz for file in sampled]), _range([file.span_s for file in sampled])
        gaps = [file.longest_gap_s for file in sampled if file.longest_gap_s is not None]
        rows.append((source, str(len(source_files)), str(n_rows), *ranges, significant(max(gaps)) if gaps else DASH))
    made.table(("source", *map(number, ("files", "rows", "rate [1/s]", "span [s]", "longest gap [s]"))), rows)


def _range(values: list[float | None], digits: int = 4) -> str:
    known = [value for value in values if value is not None]
    if not known:
        return DASH
    low, high = significant(min(known), digits), significant(max(known), digits)
    return low if low == high else f"{low} … {high}"


def _add_ranges(made: PageBuilder, files: list[CheckedSource], details: bool) -> None:
    """Add the range of each column, or of all of a signal, over all files of its source, in the units people read."""
    rows = []
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
            unit = _read_in(written)
            ends = (DASH if end is None else significant((end - unit.zero) * unit.factor, 4) for end in (low, high))
            name = names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}"
            rows.append((source, signal, name, written, *ends, unit.name, _moved(names, ranges)))
    made.table(("source", "signal", "column", "written in", number("lowest"), number("highest"), "", "moved"), rows)


def _read_in(written: str) -> ShownUnit:
    """Return the unit in which people read what a log has in another one; angles in a log are those of joints.

    Examples
    --------
    >>> _read_in("rev").name, _read_in("um").name, _read_in("degF").name, _read_in("ms").name, _read_in("counts").name
    ('°', 'mm', '°C', 's', 'counts')
    """
    si = si_unit(written)
    own = {"rad": JOINT_ANGLE, "K": TEMPERATURE}.get(si)
    return (own or quantity_of(si or written)).usual


def _moved(names: list[str], ranges: list[CheckedColumn]) -> str:
    """Return which columns moved, and of one in how many files."""
    if len(names) == 1:
        count = sum(bool(one.moved) for one in ranges)
        return "no" if not count else "yes" if count == len(ranges) else f"in {count} of {len(ranges)} files"
    still = [name for name in names if not any(one.moved for one in ranges if one.column == name)]
    return "yes" if not still else "no" if len(still) == len(names) else f"not {', '.join(still)}"


def _add_runs(made: PageBuilder, runs: list[CheckedRun], details: bool) -> None:
    """Add a row for each run; without details one for neighbours of a kind and as many states, of some of them."""

    def cells(run: CheckedRun) -> tuple[str, str, str, str]:
        size = f"{run.n_readings} readings" if run.n_readings else str(run.n_states)
        return run.experiment, size, str(len(run.set_aside)), run.id if details else ""

    alike = [(key, list(same)) for key, same in itertools.groupby(runs, cells)]
    most = len(runs) if details else MOST_RUNS
    rows = []
    for key, same in alike[:most]:
        few = ", ".join(run.id for run in same)
        name = few if len(same) < 3 else f"{same[0].id} … {same[-1].id}: {len(same)} runs"
        rows.append((name, *key[:3], _range([run.largest_force_N for run in same], 3)))
    made.table(("run", "experiment", number("states"), number("set aside"), number("largest force [N]")), rows)
    if len(alike) > most:
        made.say(f"  and {count(sum(len(same) for _, same in alike[most:]), 'more run')} (check --details)", "more")
    lines = [f"run {run.id}, {line}" for run in runs for line in run.set_aside]
    shown = lines if details else lines[:MOST_RUNS]
    for line in shown:
        made.say(f"set aside: {line}", "set-aside")
    if len(lines) > len(shown):
        made.say(f"  and {len(lines) - len(shown)} more set aside (check --details)", "more")


def _add_joints(made: PageBuilder, joints: list[CheckedJoint]) -> None:
    rows = []
    for joint in joints:
        unit = " N" if joint.prismatic else ""
        largest = joint.largest_torque_Nm
        # below the last digit of any torque sensor it is rounding of a torque that is zero
        shown = 0.0 if largest is not None and largest < 1e-6 else largest
        rows.append((joint.joint, f"{significant(shown)}{unit}", joint.says))
    made.table(("joint", number("largest torque [N·m]"), "its stiffness"), rows)
