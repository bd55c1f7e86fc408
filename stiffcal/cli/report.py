"""`stiffcal report`: the PDF."""

from __future__ import annotations

from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, Overwrite, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step


def report(
    folder: Folder = HERE,
    output: Output = None,
    short: Annotated[
        bool, typer.Option("--short", help="Two pages for a customer: the answer and the values.")
    ] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """Write the report as a PDF (DIR/report.pdf).

    Example: stiffcal report demo -o demo.pdf
    """
    with answering(as_json) as answer:
        from stiffcal.commands.report import report_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        result = report_campaign(folder, context, output=output, is_short=short)
        answer.show(result, following(folder, store, Step.REPORT))
    return OK
