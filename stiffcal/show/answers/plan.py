"""What `plan` shows: the runs, the expected uncertainties, what more runs would bring."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.planning.wording import CANDIDATES, OWN_WEIGHT, another_hour_text, indices_text, remedy_text
from stiffcal.quantity import JOINT_ANGLE, Units, quantity_of
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import DASH, count, fixed_places, length, percent, significant

if TYPE_CHECKING:
    from stiffcal.planning.results import PlanResult
    from stiffcal.presentation.values import Page
    from stiffcal.show.options import ShowOptions


MOST_RUNS, MOST_VALUES = 7, 7
"""Runs and parameters that are listed without details."""


def page(result: PlanResult, options: ShowOptions) -> Page:
    """Return the runs in the order of measuring, what they would determine, and what was written."""
    made = PageBuilder("Runs to measure")
    made.say(
        f"{len(result.runs)} runs, {result.minutes:.0f} min, chosen from {result.candidates} "
        f"{CANDIDATES[result.experiment]}; values from {result.values_from}",
        "runs",
    )
    _add_runs(made, result, options.details)
    _add_expected(made, result, options.details)
    if result.separations:
        made.head("separation of the look-alikes: misfit of the second if the first is true")
        rows = [(entry.truth, entry.rival, significant(entry.chi_square, 2)) for entry in result.separations]
        made.table(("true", "fitted instead", number("χ²")), rows)
    _add_gain(made, result, options.details)
    if result.folder is not None:
        made.say(f"wrote {result.folder}, ready for the logs in raw/", "written")
    if result.program is not None:
        made.say(f"wrote {result.program}: read its head before the first start", "written")
    if result.file is not None:
        made.say(f"wrote {result.file}", "written")
    return made.page()


def _add_runs(made: PageBuilder, result: PlanResult, details: bool) -> None:
    unit = JOINT_ANGLE.usual
    driven = ("driven", number(unit.in_brackets("to ±"))) if result.experiment == "clamped" else ()
    loaded = any(run.wrench[:, :3].any() for run in result.runs)
    angles = (number(unit.in_brackets(name)) for name in result.joint_names)
    rows = []
    for run in result.runs:
        force = run.wrench[int(np.argmax(np.linalg.norm(run.wrench[:, :3], axis=1))), :3]
        cells = [run.id, str(run.rank), *(fixed_places(angle, 1) for angle in unit.factor * run.joints)]
        if run.moved_joint is not None and run.turn is not None:
            cells += [f"joint {run.moved_joint}", significant(unit.factor * run.turn, 2)]
        if loaded:
            cells.append(", ".join(fixed_places(component, 0) for component in force) if force.any() else OWN_WEIGHT)
        rows.append(cells)
    load = (number("largest force [N]"),) if loaded else ()
    shown = rows if details or len(rows) <= MOST_RUNS + 1 else rows[:MOST_RUNS]
    made.table(("run", number("rank"), *angles, *driven, *load), shown)
    if len(shown) < len(rows):
        made.say(f"  and {count(len(rows) - len(shown), 'more run')} (plan --details, or a run sheet: -o FILE)", "more")


def _add_expected(made: PageBuilder, result: PlanResult, details: bool) -> None:
    made.head("expected uncertainty (half width of the 95 % interval)")
    with_units = result.experiment == "absolute"
    units = Units((parameter.unit, [parameter.half_width]) for parameter in result.parameters)
    rows = []
    for parameter in result.parameters:
        unit = units.of(quantity_of(parameter.unit))
        half = DASH if parameter.half_width is None else significant(unit.factor * parameter.half_width, 2)
        rows.append((parameter.name, *((half, unit.name) if with_units else ()), _percent(parameter.relative)))
    # those that will be known worst decide; what is not identifiable is named below
    worst = sorted(range(len(rows)), key=lambda k: -(result.parameters[k].relative or 0.0))
    shown = rows if details or len(rows) <= MOST_VALUES + 1 else [rows[k] for k in sorted(worst[:MOST_VALUES])]
    made.table(("parameter", *((number("±"), "unit") if with_units else ()), number("± %")), shown)
    if len(shown) < len(rows):
        made.say(f"  and {len(rows) - len(shown)} more, better known or not at all (plan --details)", "more")
    if with_units:
        made.say("for geometry and frames ± % is relative to the typical size of their errors", "relative-to")
    if result.observability is not None and details:
        made.say(indices_text(result.observability), "observability")
    if result.not_identified:
        made.say(f"not identifiable with this equipment: {', '.join(result.not_identified)}", "not-identified")
    for remedy in result.remedies or ():
        made.say(remedy_text(remedy), "remedy")
    if result.prediction_half_width_m is not None:
        what = "position" if with_units else "deflection"
        without = ", without parameters that are not identified" if result.not_identified else ""
        half = length(result.prediction_half_width_m)
        made.say(f"{what} at {result.predicted_at}: ± {half}{without}", "prediction")


def _add_gain(made: PageBuilder, result: PlanResult, details: bool) -> None:
    if details:
        made.head("after the runs of highest rank")
        rows = [(str(point.runs), f"{point.minutes:.0f}", _percent(point.worst_relative)) for point in result.gain]
        made.table((number("runs"), number("min"), number("largest ± %")), rows)
    if result.another_hour is not None:
        made.say(another_hour_text(len(result.runs), result.another_hour), "another-hour", starts_paragraph=True)
    if details:
        made.say(
            f"efficiency ({result.criterion}): {result.efficiency:.2f}, lower bound of the variance over that of this "
            f"plan (Kiefer and Wolfowitz, 1960)",
            "efficiency",
        )
    for goal in result.goals or ():
        text = f"  {goal.goal}, {percent(goal.weight)} of the goal: {goal.efficiency:.2f} for this goal alone"
        made.say(text, "goal")


def _percent(relative: float | None) -> str:
    return DASH if relative is None else significant(100.0 * relative, 2)
