"""`stiffcal diagnose`: is the model good enough, and if not, which physical effect is missing."""

from __future__ import annotations

from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step
from stiffcal.show.options import ShowOptions


def diagnose(
    folder: Folder = HERE,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    jobs: Annotated[
        int, typer.Option("--jobs", metavar="N", min=1, help="Number of threads; the answer is the same.")
    ] = 1,
) -> int:
    """Find which physical effect the model lacks.

    Compares every set of effects, mistakes in the data and laws of no catalogue that is worth it, and states how
    probable each effect is, what looks the same, and whether anything is missing; the error in held-out poses shows
    what adding it does.

    Example: stiffcal diagnose demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.diagnose import diagnose_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, jobs=jobs, progress=answer.progress, notify=answer.notify
        )
        result = diagnose_campaign(folder, context)
        then = following(folder, store, Step.DIAGNOSE)
        answer.show(result, then, ShowOptions(details, folder, store))
    return OK
