"""`stiffcal plan`: which poses and loads to measure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, OverwriteAlone, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, length, significant
from stiffcal.escapes.shell import command_line
from stiffcal.quantity import Units, quantity_of

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.planning.results import PlanResult


def plan(
    folder: Folder = HERE,
    purpose: Annotated[
        str,
        typer.Option(
            "--for",
            metavar="WHAT",
            help="stiffness; look-alikes (of the last diagnosis); region (of plan.toml); a CSV of poses and loads to "
            'predict well; or a mix, as "stiffness=2, path.csv=1".',
        ),
    ] = "stiffness",
    tell: Annotated[
        tuple[str, str] | None,
        typer.Option(metavar="A B", help='Two effects to distinguish: --tell "backlash j4" "two-slope j4".'),
    ] = None,
    criterion: Annotated[
        Literal["determinant", "worst"] | None,
        typer.Option(
            help="For stiffness: joint confidence region (of absolute poses the default), or largest relative "
            "uncertainty.",
            show_default=False,
        ),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(min=1, max=1000, help="Number of runs (default: the budget of plan.toml).", show_default=False),
    ] = None,
    force: Annotated[
        float | None,
        typer.Option(min=1e-3, metavar="N", help="Largest force, N (default: that of plan.toml).", show_default=False),
    ] = None,
    campaign: Annotated[
        Path | None,
        typer.Option("--campaign", metavar="OUT", help="Create a campaign folder for the logs.", show_default=False),
    ] = None,
    program: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Robot program of the joint moves: .src (KUKA), .mod (ABB), .script (UR), .ls (FANUC).",
            show_default=False,
        ),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: OverwriteAlone = False,
) -> int:
    """Plan which poses and loads to measure.

    The limits are those of DIR/plan.toml: joint limits, boxes, position of the tracker, loads, minutes. -o writes a
    run sheet (.csv, .xlsx or .pdf), --campaign a folder for the logs that `check` reads while you measure.

    Example: stiffcal plan campaigns/irb4400 --force 450 --runs 8 -o runs.csv
    """
    with answering(as_json) as answer:
        from stiffcal.commands.plan import PlanRequest, plan_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        request = PlanRequest(purpose, criterion, runs, force, output, tell or (), program, campaign)
        result = plan_campaign(folder, context, request)
        options = [("--for", purpose)] if purpose != "stiffness" else []
        options += [("--criterion", criterion)] if criterion is not None else []
        options += [("--runs", f"{runs}")] if runs is not None else []
        options += [("--force", f"{force:g}")] if force is not None else []
        words = [word for option in options for word in option] + (["--tell", *tell] if tell else [])
        answer.give(result, show_plan, after_plan(folder, campaign, words, store))
    return OK


def after_plan(folder: Path, campaign: Path | None, words: Sequence[str], store: str | None) -> NextLine:
    """Return the same plan with a folder for its logs; where that is made, its check once they are there.

    Parameters
    ----------
    folder : the campaign that the plan is made for. campaign : the folder made for the logs; None: none yet.
    words : the options that the plan was made with. store : where results are kept; None: in the folder.
    """
    planned = folder / "planned"
    if campaign is None and not planned.exists():
        return NextLine(command_line("plan", folder, *words, "--campaign", str(planned), store=store))
    return NextLine(command_line("check", campaign or folder), once="runs are measured")


def show_plan(console: Console, result: PlanResult) -> None:
    """Draw the runs, the expected uncertainties, and what more runs would bring."""
    import numpy as np

    from stiffcal.planning.wording import CANDIDATES, OWN_WEIGHT

    console.print(
        f"{len(result.runs)} runs, {result.minutes:.0f} min, chosen from {result.candidates} "
        f"{CANDIDATES[result.experiment]}; "
        f"values from {result.values_from}"
    )
    driven = ("driven", "to ± [°]>") if result.experiment == "clamped" else ()
    loaded = any(run.wrench[:, :3].any() for run in result.runs)
    angle_titles = (f"{name} [°]>" for name in result.joint_names)
    table = plain_table("run", "rank>", *angle_titles, *driven, *(("largest force [N]>",) if loaded else ()))
    for run in result.runs:
        force = run.wrench[int(np.argmax(np.linalg.norm(run.wrench[:, :3], axis=1))), :3]
        angles = [f"{angle:.1f}" for angle in np.degrees(run.joints)]
        load = ", ".join(f"{component:.0f}" for component in force + 0.0) if force.any() else OWN_WEIGHT
        motor = (
            ()
            if run.moved_joint is None or run.turn is None
            else (f"joint {run.moved_joint}", significant(float(np.degrees(run.turn)), 2))
        )
        table.add_row(run.id, str(run.rank), *angles, *motor, *((load,) if loaded else ()))
    console.print(table)
    _show_expected(console, result)
    if result.separations:
        console.print("\nseparation of the look-alikes: misfit of the second if the first is true")
        table = plain_table("true", "fitted instead", "χ²>")
        for entry in result.separations:
            table.add_row(entry.truth, entry.rival, significant(entry.chi_square, 2))
        console.print(table)
    _show_gain(console, result)
    if result.folder is not None:
        console.print(f"wrote {result.folder}, ready for the logs in raw/", soft_wrap=True)
    if result.program is not None:
        console.print(f"wrote {result.program}: read its head before the first start", soft_wrap=True)
    if result.file is not None:
        console.print(f"wrote {result.file}", soft_wrap=True)


def _show_expected(console: Console, result: PlanResult) -> None:
    from stiffcal.planning.wording import indices_text, remedy_text

    console.print("\nexpected uncertainty (half width of the 95 % interval)")
    with_units = result.experiment == "absolute"
    table = plain_table("parameter", *(("±>", "unit") if with_units else ()), "± %>")
    units = Units((parameter.unit, [parameter.half_width]) for parameter in result.parameters)
    for parameter in result.parameters:
        known = NOT_KNOWN if parameter.relative is None else significant(100.0 * parameter.relative, 2)
        unit = units.of(quantity_of(parameter.unit))
        half = NOT_KNOWN if parameter.half_width is None else significant(unit.factor * parameter.half_width, 2)
        table.add_row(parameter.name, *((half, unit.name) if with_units else ()), known)
    console.print(table)
    if with_units:
        console.print("for geometry and frames ± % is relative to the typical size of their errors")
    if result.observability is not None:
        console.print(indices_text(result.observability))
    if result.not_identified:
        console.print(f"not identifiable with this equipment: {', '.join(result.not_identified)}")
    for remedy in result.remedies or ():
        console.print(remedy_text(remedy))
    if result.prediction_half_width_m is not None:
        what = "position" if with_units else "deflection"
        without = ", without parameters that are not identified" if result.not_identified else ""
        console.print(f"{what} at {result.predicted_at}: ± {length(result.prediction_half_width_m)}{without}")


def _show_gain(console: Console, result: PlanResult) -> None:
    from stiffcal.planning.wording import another_hour_text

    console.print("\nafter the runs of highest rank")
    table = plain_table("runs>", "min>", "largest ± %>")
    for point in result.gain:
        worst = NOT_KNOWN if point.worst_relative is None else significant(100.0 * point.worst_relative, 2)
        table.add_row(str(point.runs), f"{point.minutes:.0f}", worst)
    console.print(table)
    if result.another_hour is not None:
        console.print(another_hour_text(len(result.runs), result.another_hour))
    console.print(
        f"efficiency ({result.criterion}): {result.efficiency:.2f}, lower bound of the variance over that of this "
        f"plan (Kiefer and Wolfowitz, 1960)"
    )
    for goal in result.goals or ():
        console.print(
            f"  {goal.goal}, {100.0 * goal.weight:.0f} % of the goal: {goal.efficiency:.2f} for this goal alone"
        )
