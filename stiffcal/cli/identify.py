"""`stiffcal identify`: fit the model, show the stiffness table."""

from __future__ import annotations

from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step
from stiffcal.show.options import ShowOptions


def identify(
    folder: Folder = HERE,
    loss: Annotated[str, typer.Option(help="linear (least squares) or huber (less weight for outliers).")] = "linear",
    dual_quaternions: Annotated[
        bool,
        typer.Option(
            "--dual-quaternions",
            help="Joint springs as dual quaternions too (Li et al. 2019), next to the matrix form.",
        ),
    ] = False,
    coupling: Annotated[
        bool, typer.Option("--coupling", help="With rods on a link: compare with the fit that does not use them.")
    ] = False,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Fit the model: each stiffness with its uncertainty.

    Also lists parameters that the data do not identify, and the expected error in new poses.

    Example: stiffcal identify demo --loss huber
    """
    with answering(as_json) as answer:
        from stiffcal.commands.identify import identify_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        result = identify_campaign(folder, context, loss, dual_quaternions, coupling)
        answer.show(result, following(folder, store, Step.IDENTIFY), ShowOptions(details, folder, store))
    return OK
