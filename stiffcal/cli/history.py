"""`stiffcal history`: every fit of this campaign, and the way back to an earlier model."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Folder, Overwrite, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import deviation, places
from stiffcal.errors import one_line
from stiffcal.model.summary import EffectInModel
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
    table = plain_table("fit", "time", "model", "error>", "noise>")
    models = [fit.model for fit in result.fits] + ([] if result.not_fitted_yet is None else [result.not_fitted_yet])
    steps = [model_in_words(models[0]), *(step_in_words(*pair) for pair in pairwise(models))]
    for fit, step in zip(result.fits, steps, strict=False):
        table.add_row(
            fit.id + ("" if fit.origin in (None, "own") else f" ({NOT_YOURS[fit.origin]})"),
            fit.time.replace("T", " ")[:16],
            step,
            deviation(fit.heldout_rms) if fit.heldout_rms is not None else "unvalidated",
            deviation(fit.noise),
        )
    if result.not_fitted_yet is not None:
        table.add_row("now", "not fitted yet", steps[-1], "", "")
    console.print(f"error: rms in {left_out}")
    console.print(table)


def step_in_words(before: ModelSummary, after: ModelSummary) -> str:
    """Return what a model has more and less than the one before it: a whole model takes more than a line of 80 columns.

    Examples
    --------
    >>> from stiffcal.model.summary import EffectInModel, ModelSummary
    >>> drives, play = EffectInModel("joint-compliance", joints=[1, 2]), EffectInModel("backlash", joints=[4])
    >>> step_in_words(ModelSummary("deformed", [drives]), ModelSummary("deformed", [drives, play]))
    '+ backlash (joint 4)'
    >>> step_in_words(ModelSummary("deformed", [drives, play]), ModelSummary("first-order", [drives]))
    '− backlash (joint 4), first-order balance'
    """
    gone = [f"− {_effect_in_words(effect)}" for effect in _not_in(after, before)]
    new = [f"+ {_effect_in_words(effect)}" for effect in _not_in(before, after)]
    balance = f"{after.balance} balance" if before.balance != after.balance else ""
    return ", ".join(filter(None, (" ".join(gone + new), balance))) or "same model"


def model_in_words(model: ModelSummary) -> str:
    """Return a model as one phrase.

    Examples
    --------
    >>> from stiffcal.model.summary import EffectInModel, ModelSummary
    >>> model_in_words(ModelSummary("deformed", [EffectInModel("backlash", joints=[4])]))
    'backlash (joint 4)'
    """
    effects = map(_effect_in_words, model.effects)
    first_order = ", first-order balance" if model.balance == "first-order" else ""
    return " + ".join(effects) + first_order


def _effect_in_words(effect: EffectInModel) -> str:
    return f"{effect.type} ({places(effect.where)})"


def _not_in(other: ModelSummary, model: ModelSummary) -> Iterator[EffectInModel]:
    """Yield the effects of a model that another one does not hold, each with the places at which it does not."""
    held = {effect.type: dict(effect.where.items()) for effect in other.effects}
    for effect in model.effects:
        there = held.get(effect.type)
        if there is None:
            yield effect
            continue
        missing = {
            kind: places
            for kind, all_places in effect.where.items()
            if (places := [place for place in all_places if place not in there.get(kind, [])])
        }
        if missing:
            yield EffectInModel(effect.type, **missing)
