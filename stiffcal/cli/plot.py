"""`stiffcal plot`: one picture."""

from __future__ import annotations

from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, Overwrite, StoreAt
from stiffcal.commands.next_step import following


def plot(
    folder: Folder = HERE,
    run: Annotated[str | None, typer.Option(metavar="X", help="Only this run.", show_default=False)] = None,
    against: Annotated[
        str | None,
        typer.Option(
            metavar="WHAT:JOINT",
            help="Draw the residual against torque:4, angle:2, time, hold, load, …; velocity:2: friction.",
            show_default=False,
        ),
    ] = None,
    of: Annotated[
        str | None,
        typer.Option(
            metavar="WHAT",
            help="Draw the fit: normal (residuals against a normal law), influence (of each run on each value), "
            "correlation, profile (of values near a bound, or that bend a law), history.",
            show_default=False,
        ),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """Draw load against deformation, the residual, or what a fit's statistics hang on.

    The residual against any logged variable; SVG, PNG or PDF by the ending of the file name. The picture goes to
    DIR/plot.svg, or to -o.

    Example: stiffcal plot demo --against torque:4 -o residual.svg
    """
    with answering(as_json) as answer:
        from stiffcal.commands.plot import plot_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        result = plot_campaign(folder, context, output=output, run=run, against=against, of=of)
        answer.show(result, following(folder, store))
    return OK
