"""`stiffcal add`: put an effect into model.toml."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, Joints, Links, Pairs
from stiffcal.commands.next_step import following

Model = Annotated[Path, typer.Argument(metavar="DIR", help="The campaign folder.")]
EffectName = Annotated[str, typer.Argument(metavar="EFFECT", help="Name of the effect, see `stiffcal effects`.")]
Curved = Annotated[
    bool,
    typer.Option("--curved", help="Nonlinear springs (quadratic and cubic terms): bearing-tilt, joint-translation."),
]
Start = Annotated[
    str | None,
    typer.Option(
        "--start", metavar="SYMBOL=VALUE,…", help="Start values of the fit, SI; their names select the form of the law."
    ),
]
Everywhere = Annotated[bool, typer.Option("--all", help="At every possible place.")]


def add(
    folder: Model,
    effect: EffectName,
    joints: Joints = None,
    links: Links = None,
    pairs: Pairs = None,
    everywhere: Everywhere = False,
    curved: Curved = False,
    start: Start = None,
    as_json: AsJson = False,
) -> int:
    """Add a physical effect to model.toml.

    Your comments stay.

    Example: stiffcal add demo backlash --joints 4
    """
    where = {"joints": joints, "links": links, "pairs": pairs}
    return edit(folder, "add", effect, where, everywhere, as_json, curved=curved, start=start)


def edit(
    folder: Path,
    action: Literal["add", "remove"],
    effect: str,
    where: Mapping[str, str | None],
    everywhere: bool,
    as_json: bool,
    *,
    curved: bool = False,
    start: str | None = None,
) -> int:
    """Change model.toml and show what it holds now; of `add` and `remove`."""
    with answering(as_json) as answer:
        from stiffcal.commands.edit_model import edit_model, start_values

        values = start_values(start)
        result = edit_model(folder, action, effect, where=where, everywhere=everywhere, curved=curved, start=values)
        answer.show(result, following(folder, None))
    return OK
