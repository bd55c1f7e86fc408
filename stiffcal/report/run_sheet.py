"""The run sheet of a plan on paper: what to measure, in order, with room to tick it off."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.errors import Progress, no_progress
from stiffcal.planning.wording import (
    CANDIDATES,
    OWN_WEIGHT,
    another_hour_text,
    direction_and_sizes,
    indices_text,
    remedy_text,
)
from stiffcal.quantity import Units, quantity_of
from stiffcal.report.blocks import Facts, Items, Paragraph, PictureBlock, ReportSection, TableBlock, TableColumn
from stiffcal.report.building import PagesHeading, write_pages
from stiffcal.report.figures.gain import draw_gain
from stiffcal.wording import length, significant

if TYPE_CHECKING:
    from stiffcal.planning.results import ExpectedParameter, PlanResult, RunToMeasure

NOT_KNOWN = "–"
BOX = "□"
KINDS = {
    "load": "Load-deflection calibration",
    "absolute": "Calibration by absolute poses",
    "clamped": "Calibration of a clamped robot",
}


def build_run_sheet(
    plan: PlanResult, robot: str, campaign: str, sources: tuple[str, ...], date: str, output: Path,
    progress: Progress = no_progress,
) -> None:  # fmt: skip
    """Write the run sheet as a PDF.

    Parameters
    ----------
    plan : what to measure.
    robot, campaign : their names.
    sources : names of the logging devices, as campaign.toml has them, or of their files.
    date : ISO date that is printed.
    output : where to write.
    progress : receives each step.

    Raises
    ------
    OSError : `output` cannot be written.
    """
    kind = KINDS[plan.experiment]
    heading = PagesHeading(title=f"Run sheet, {robot}", kind=kind, campaign=campaign, date=date, maker="stiffcal",
        has_contents=False)  # fmt: skip
    loads = () if plan.experiment == "absolute" else (_steps(plan),)
    sections = (_overview(plan, sources), _runs(plan), *loads, _expected(plan))
    write_pages(heading, sections, output, progress)


def _overview(plan: PlanResult, sources: tuple[str, ...]) -> ReportSection:
    facts = [
        ("Runs", f"{len(plan.runs)}, {plan.minutes:.0f} min{_warm_up(plan)}"),
        ("Log", ", ".join(sources) or NOT_KNOWN),
        ("Values of the plan", plan.values_from),
        ("Chosen from", f"{plan.candidates} {CANDIDATES[plan.experiment]}, efficiency {plan.efficiency:.2f}"),
    ]
    minutes, state = plan.runs[0].minutes, plan.runs[0].minutes_per_state
    reading = {
        "load": "In every run: measure unloaded, at each load step in order, and unloaded again, each for the same "
        "time: "
        f"{state:g} min, {minutes:g} min a run.",
        "absolute": f"In every run: let the robot come to rest, and measure the pose once; {minutes:g} min a run.",
        "clamped": "In every run: clamp the flange, measure, then drive the listed joint back and forth, up to the "
        f"listed angle; stop at the limits of the sensor. {minutes:g} min a run.",
    }[plan.experiment]
    notes = [
        *((f"Move all joints for {plan.warm_up_minutes:g} min before the first run.",) if plan.warm_up_minutes else ()),
        "Poses and joint moves were checked only against joint limits, keep-out boxes and link capsules of plan.toml.",
        "They were not checked against neighbouring links, cables, the load, or people.",
        reading,
        "If time is short, measure the runs with the highest rank first.",
        *(
            f"From {before} to {after} no collision-free joint move was found: move by hand."
            for before, after in plan.blocked_moves
        ),
        *(
            f"{loss.parameter} depends on {loss.run}: check its logs before the set-up is dismantled."
            for loss in plan.rests_on_one_run
        ),
    ]
    return ReportSection("Before the first run", (Facts(tuple(facts)), Items(tuple(notes))))


def _warm_up(plan: PlanResult) -> str:
    return f", {plan.warm_up_minutes:g} min of warm-up included" if plan.warm_up_minutes else ""


def _runs(plan: PlanResult) -> ReportSection:
    clamped = plan.experiment == "clamped"
    loaded = any(run.wrench[:, :3].any() for run in plan.runs)
    columns = (
        TableColumn("run", align="left"),
        TableColumn("rank"),
        *(TableColumn(name, "°") for name in plan.joint_names),
        *((TableColumn("driven", align="left"), TableColumn("to ±", "°")) if clamped else ()),
        *((TableColumn("force, base axes", "N", align="left", width=1.0),) if loaded else ()),
        TableColumn("done", align="left"),
    )
    rows = []
    for run in plan.runs:
        empty = ("",) * (len(columns) - 2 - len(plan.joint_names))
        rows += [("intermediate pose", "", *_degrees(joints), *empty) for joints in run.approach]
        largest = run.wrench[int(np.argmax(np.linalg.norm(run.wrench[:, :3], axis=1))), :3] + 0.0
        force = _true_minus(", ".join(f"{component:.0f}" for component in largest)) if largest.any() else OWN_WEIGHT
        motor = (
            ()
            if run.moved_joint is None or run.turn is None
            else (f"joint {run.moved_joint}", significant(float(np.degrees(run.turn)), 2))
        )
        rows.append((run.id, str(run.rank), *_degrees(run.joints), *motor, *((force,) if loaded else ()), BOX))
    caption = "Runs in measuring order."
    if loaded:
        caption = f"Runs in measuring order; force: largest of each run{', as expected at the fixture' * clamped}."
    else:
        caption += " The robot is loaded by its own weight alone."
    return ReportSection("Runs", (TableBlock(columns, tuple(rows), caption),))


def _steps(plan: PlanResult) -> ReportSection:
    columns = (
        TableColumn("runs", align="left", width=1.0),
        TableColumn("direction, base axes", align="left"),
        TableColumn("steps", "N", align="left", width=2.0),
    )
    alike: dict[tuple[str, str], list[str]] = {}
    for run in plan.runs:
        alike.setdefault(_load(run), []).append(run.id)
    rows = tuple((", ".join(ids), direction, steps) for (direction, steps), ids in alike.items())
    if plan.experiment == "clamped":
        caption = "Force to expect at the fixture while the joint is driven, in order, along the direction."
        return ReportSection("Expected forces", (TableBlock(columns, rows, caption),))
    caption = (
        "Load steps in order, along the direction; 0 is unloaded. Unloaded states before and after are not listed."
    )
    return ReportSection("Load steps", (TableBlock(columns, rows, caption),))


def _expected(plan: PlanResult) -> ReportSection:
    columns = (
        TableColumn("parameter", align="left", width=1.0),
        TableColumn("value"),
        TableColumn("± 95 %"),
        TableColumn("±", "%"),
        TableColumn("unit", align="left"),
    )
    units = Units((parameter.unit, [parameter.value]) for parameter in plan.parameters)
    rows = tuple(_parameter_row(parameter, units) for parameter in plan.parameters)
    blocks: list[Paragraph | TableBlock | PictureBlock] = [TableBlock(columns, rows, "Expected after all runs.")]
    if plan.not_identified:
        blocks.append(Paragraph(f"Not identifiable with this equipment: {', '.join(plan.not_identified)}."))
    blocks += [Paragraph(f"{remedy_text(remedy)}.") for remedy in plan.remedies or ()]
    if plan.observability is not None:
        blocks.append(Paragraph(f"{_sentence(indices_text(plan.observability))}."))
    if plan.prediction_half_width_m is not None:
        what = "Position" if plan.experiment == "absolute" else "Deflection"
        blocks.append(Paragraph(f"{what} at {plan.predicted_at}: ± {length(plan.prediction_half_width_m)}."))
    for entry in plan.separations or ():
        blocks.append(
            Paragraph(f"If {entry.truth} is true, {entry.rival} fits worse by χ² = {significant(entry.chi_square, 2)}.")
        )
    if any(point.worst_relative is not None for point in plan.gain):
        caption = (
            "Largest half width of all parameters identified by then, over the number of runs, highest rank first."
        )
        blocks.append(PictureBlock(partial(draw_gain, plan.gain), caption))
    if plan.another_hour is not None:
        blocks.append(Paragraph(f"{_sentence(another_hour_text(len(plan.runs), plan.another_hour))}."))
    return ReportSection("Expected results of these runs", tuple(blocks))


def _parameter_row(parameter: ExpectedParameter, units: Units) -> tuple[str, ...]:
    """Return a parameter with its half width, in the unit that people read."""
    unit = units.of(quantity_of(parameter.unit))
    half = None if parameter.half_width is None else unit.factor * parameter.half_width
    share = _number(None if parameter.relative is None else 100.0 * parameter.relative)
    return parameter.name, _true_minus(significant(unit.factor * parameter.value)), _number(half), share, unit.name


def _load(run: RunToMeasure) -> tuple[str, str]:
    direction, sizes = direction_and_sizes(run.wrench) or (OWN_WEIGHT, "0")
    return _true_minus(direction), _true_minus(sizes)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _degrees(joints: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> tuple[str, ...]:
    return tuple(_true_minus(f"{angle + 0.0:.2f}") for angle in np.degrees(joints))


def _true_minus(number: str) -> str:
    return number.replace("-", "−")


def _number(value: float | None) -> str:
    return NOT_KNOWN if value is None else significant(value, 2)
