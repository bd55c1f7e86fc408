"""`stiffcal remove`: take an effect out of model.toml."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.add import Everywhere, show_edit
from stiffcal.cli.answers import answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, Joints, Links, Pairs


def remove(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The campaign folder.")],
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="Its name, see `stiffcal effects`.")],
    joints: Joints = None,
    links: Links = None,
    pairs: Pairs = None,
    everywhere: Everywhere = False,
    as_json: AsJson = False,
) -> int:
    """Remove a physical effect from model.toml.

    Your comments stay.

    Example: stiffcal remove demo backlash --joints 4
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.edit_model import edit_model

        where = {"joints": joints, "links": links, "pairs": pairs}
        document = edit_model(folder, "remove", effect, where=where, everywhere=everywhere)
        answer.give(document, show_edit, command_line("identify", folder))
    return OK
