"""`stiffcal plan`: which poses and loads to measure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, Output, OverwriteAlone, StoreAt
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep
from stiffcal.show.options import ShowOptions


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
    details: Details = False,
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
        from stiffcal.commands.plan import plan_campaign
        from stiffcal.planning.campaign.request import PlanRequest
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
        answer.show(result, after_plan(folder, campaign, words, store), ShowOptions(details, folder, store))
    return OK


def after_plan(folder: Path, campaign: Path | None, words: Sequence[str], store: str | None) -> NextStep:
    """Return the same plan with a folder for its logs; where that is made, its check once they are there.

    Parameters
    ----------
    folder : the campaign that the plan is made for. campaign : the folder made for the logs; None: none yet.
    words : the options that the plan was made with. store : where results are kept; None: in the folder.
    """
    planned = folder / "planned"
    if campaign is None and not planned.exists():
        return NextStep(command_line("plan", folder, *words, "--campaign", str(planned), store=store))
    return NextStep(command_line("check", campaign or folder), once="runs are measured")
