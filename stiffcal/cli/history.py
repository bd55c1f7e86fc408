"""`stiffcal history`: every fit of this campaign, and the way back to an earlier model."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, deviation, places
from stiffcal.errors import one_line

NOT_YOURS = {"foreign": "not computed by you", "trusted place": "trusted place"}

if TYPE_CHECKING:
    from rich.console import Console


def history(
    folder: Folder = HERE,
    restore: Annotated[
        str | None,
        typer.Option("--restore", metavar="ID", help="Write that fit's model back to model.toml.", show_default=False),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Restore a model that somebody else has made without asking.")
    ] = False,
    as_json: AsJson = False,
    store: StoreAt = None,
) -> int:
    """List every fit: model, error in unseen poses, noise.

    Example: stiffcal history demo --restore 1
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.history import read_history, restore_model
        from stiffcal.workflow.steps import RunContext

        context = RunContext(store=store, update=False, progress=answer.progress, say=answer.say)
        if restore is not None:
            answer.say(restore_model(folder, context, restore, lambda entry: agrees(answer, entry, yes)))
        document = read_history(folder, context)
        fits = document["fits"]
        if not fits or document.get("not_fitted_yet"):
            then = "identify"
        else:
            then = "report" if fits[-1]["heldout_rms"] else "validate"
        answer.give(document, show_history, command_line(then, folder, store=store))
    return OK


def agrees(answer: Answer, entry: Document, yes: bool) -> bool:
    """Show a model that somebody else has made, and ask whether it is to become this campaign's.

    Without a terminal nobody can be asked: then only ``--yes`` agrees.
    """
    answer.say(f"fit {entry['id']} was not made by you; its model file:")
    for line in entry["model_text"].splitlines() or ["(none: the default model)"]:
        answer.say("    " + one_line(line, 2000))
    if yes or answer.as_json or not sys.stdin.isatty():
        return yes
    return typer.confirm("write it to model.toml?", default=False, err=True)


def show_history(console: Console, document: Document) -> None:
    """Draw the ladder of fits."""
    if not document["fits"]:
        console.print("no fit yet")
        return
    table = plain_table("id", "time", "model", "unseen poses, rms>", "fit, rms>", "noise>")
    for fit in document["fits"]:
        heldout = deviation(fit["heldout_rms"]) if fit["heldout_rms"] else "not validated"
        noise = deviation(fit["noise"]) if fit["noise"] else NOT_KNOWN
        table.add_row(
            fit["id"] + ("" if fit.get("origin", "own") == "own" else f" ({NOT_YOURS[fit['origin']]})"),
            fit["time"].replace("T", " ")[:16],
            model_in_words(fit["model"]),
            heldout,
            deviation(fit["fit_rms"]),
            noise,
        )
    if document.get("not_fitted_yet"):
        table.add_row("now", "", model_in_words(document["not_fitted_yet"]), "not fitted yet", "", "")
    console.print(table)


def model_in_words(model: Document) -> str:
    """Return a model document as one phrase.

    Examples
    --------
    >>> model_in_words({"balance": "deformed", "effects": [{"type": "backlash", "joints": [4]}]})
    'backlash (joint 4)'
    """
    words = []
    for effect in model["effects"]:
        where = {kind: effect[kind] for kind in ("joints", "links", "pairs") if effect.get(kind)}
        words.append(f"{effect['type']} ({places(where)})")
    first_order = ", first-order balance" if model.get("balance") == "first-order" else ""
    return " + ".join(words) + first_order
