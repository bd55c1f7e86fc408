"""`stiffcal history`: every fit of this campaign, and the way back to an earlier model."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, Overwrite, StoreAt
from stiffcal.commands.next_step import line_of
from stiffcal.errors import one_line

if TYPE_CHECKING:
    from stiffcal.results.history_results import StoredFit


def history(
    folder: Folder = HERE,
    restore: Annotated[
        str | None,
        typer.Option(
            "--restore", metavar="ID", help="Write the model of this fit back to model.toml.", show_default=False
        ),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Restore a model that is not from you without asking.")] = False,
    as_json: AsJson = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """List every fit: model, error in held-out data, noise.

    Example: stiffcal history demo --restore 1
    """
    with answering(as_json) as answer:
        from stiffcal.commands.history import read_history, restore_model
        from stiffcal.commands.standing import standing_of
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=False, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        if restore is not None:
            answer.notify(restore_model(folder, context, restore, lambda fit: agrees(answer, fit, yes)))
        result = read_history(folder, context)
        answer.show(result, line_of(folder, standing_of(folder, context, result), store))
    return OK


def agrees(answer: Answer, fit: StoredFit, yes: bool) -> bool:
    """Show a model that somebody else has made, and ask whether it is to become this campaign's.

    Without a terminal nobody can be asked: then only ``--yes`` agrees.
    """
    answer.notify(f"fit {fit.id} was not computed by you; its model file:")
    for line in fit.model_text.splitlines() or ["(none: the default model)"]:
        answer.notify("    " + one_line(line, 2000))
    if yes or answer.as_json or not sys.stdin.isatty():
        return yes
    return typer.confirm("write it to model.toml?", default=False, err=True)
