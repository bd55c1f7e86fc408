"""`stiffcal add`: put an effect into model.toml."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, Joints, Links, Pairs

if TYPE_CHECKING:
    from rich.console import Console

Everywhere = Annotated[bool, typer.Option("--all", help="Every place the effect can have.")]


def add(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The campaign folder.")],
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="Its name, see `stiffcal effects`.")],
    joints: Joints = None,
    links: Links = None,
    pairs: Pairs = None,
    everywhere: Everywhere = False,
    as_json: AsJson = False,
) -> int:
    """Add a physical effect to model.toml.

    Your comments stay.

    Example: stiffcal add demo backlash --joints 4
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.edit_model import edit_model

        where = {"joints": joints, "links": links, "pairs": pairs}
        document = edit_model(folder, "add", effect, where=where, everywhere=everywhere)
        answer.give(document, show_edit, command_line("identify", folder))
    return OK


def show_edit(console: Console, document: Document) -> None:
    """Say what changed and what the model holds now."""
    from stiffcal.cli.history import model_in_words

    for line in document["changes"]:
        console.print(line, soft_wrap=True)
    console.print(f"model now: {model_in_words(document['model'])}, not fitted yet", soft_wrap=True)
