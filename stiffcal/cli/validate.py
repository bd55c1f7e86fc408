"""`stiffcal validate`: the model against measurement in held-out poses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, StoreAt, Thresholds
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step
from stiffcal.show.options import ShowOptions


def validate(
    folder: Folder = HERE,
    model: Annotated[
        Path | None,
        typer.Option(
            "--model", metavar="OTHER_DIR", help="Validate the fitted model of another campaign with these data."
        ),
    ] = None,
    thresholds: Thresholds = None,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Validate the model in held-out poses, runs or regions.

    Lists the largest errors. Exit code 1 if a threshold of campaign.toml, or of --thresholds, is exceeded.

    Example: stiffcal validate demo
    """
    with answering(as_json) as answer:
        from stiffcal.campaign.manifest.thresholds import load_thresholds
        from stiffcal.commands.validate import validate_campaign
        from stiffcal.stages.steps import RunContext

        file = load_thresholds(thresholds) if thresholds else None
        reach = (folder, *([model] if model else []), *(file.baselines() if file else []))
        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, reach=reach
        )
        result = validate_campaign(folder, context, model=model, thresholds=file)
        # another campaign's model is no step of this one's loop
        after = Step.VALIDATE if model is None else None
        answer.show(result, following(folder, store, after), ShowOptions(details, folder, store))
    return OK if result.passed else NOT_HELD
