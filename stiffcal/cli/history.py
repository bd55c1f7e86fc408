"""`stiffcal history`: every fit of this campaign, and the way back to an earlier model."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Folder, Overwrite, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import deviation, places
from stiffcal.errors import one_line
from stiffcal.validation.schemes import held_out

NOT_YOURS = {"foreign": "not computed by you", "trusted place": "trusted place"}

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.model.summary import ModelSummary
    from stiffcal.results.history_results import HistoryResult, StoredFit


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
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=False, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        if restore is not None:
            answer.notify(restore_model(folder, context, restore, lambda fit: agrees(answer, fit, yes)))
        result = read_history(folder, context)
        answer.give(result, show_history, following(folder, store))
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


def show_history(console: Console, result: HistoryResult) -> None:
    """Draw the ladder of fits."""
    if not result.fits:
        console.print("no fit yet")
        return
    schemes = {fit.scheme for fit in result.fits if fit.heldout_rms is not None}
    left_out = held_out(schemes.pop() if len(schemes) == 1 else None)
    table = plain_table("fit", "time", "model", f"{left_out}, rms>", "fitted, rms>", "noise>")
    for fit in result.fits:
        table.add_row(
            fit.id + ("" if fit.origin in (None, "own") else f" ({NOT_YOURS[fit.origin]})"),
            fit.time.replace("T", " ")[:16],
            model_in_words(fit.model),
            deviation(fit.heldout_rms) if fit.heldout_rms is not None else "not validated",
            deviation(fit.fit_rms),
            deviation(fit.noise),
        )
    if result.not_fitted_yet is not None:
        table.add_row("now", "", model_in_words(result.not_fitted_yet), "not fitted yet", "", "")
    console.print(table)


def model_in_words(model: ModelSummary) -> str:
    """Return a model as one phrase.

    Examples
    --------
    >>> from stiffcal.model.summary import EffectInModel, ModelSummary
    >>> model_in_words(ModelSummary("deformed", [EffectInModel("backlash", joints=[4])]))
    'backlash (joint 4)'
    """
    effects = [f"{effect.type} ({places(effect.where)})" for effect in model.effects]
    first_order = ", first-order balance" if model.balance == "first-order" else ""
    return " + ".join(effects) + first_order
