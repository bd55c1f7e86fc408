"""`stiffcal effects`: the catalogue of physical effects."""

from __future__ import annotations

import re
import textwrap
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Output, Overwrite
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import significant
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.escapes.terminal import escaped
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.cli.answers import Answer
    from stiffcal.results.command_results import EffectDescription, EffectsResult


PLACES = {
    "joints": ("a joint, by number or name", "--joints 4"),
    "links": ("a link, by name", "--links swing"),
    "pairs": ("a pair of joints", "--pairs 5-6"),
    "set-up": ("the set-up: once per model", ""),
}
ACTS = {
    "node law": "small displacement at this place",
    "coupling": "coupling between two joints",
    "configuration": "changes the inputs of the static equilibrium",
    "observation": "changes what the instruments read",
    "torque in motion": "torque of the drive while the joint moves",
}
# Text wider than this tires the eye.
WIDEST = 96
HEADINGS = {"law": "Law", "assumes": "Assumptions", "limits": "Where it ends"}


def effects(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="One effect in full; or: new.", show_default=False)
    ] = None,
    new_name: Annotated[
        str | None, typer.Argument(metavar="NEW_NAME", help="After new: what to call it.", show_default=False)
    ] = None,
    source: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="DIR", help="The campaign whose own effects count too; after new: that needs it."
        ),
    ] = None,
    as_json: AsJson = False,
    output: Output = None,
    overwrite: Overwrite = False,
) -> int:
    """List the physical effects, or explain one.

    With a name: physics, law, places, parameters with units and typical sizes, required data, fingerprint, look-alikes,
    how to check it, and a sketch of its load-deformation curve; -o FILE draws the sketch as a picture.

    With --from DIR the effects of that campaign's plugins are listed too, once you trust them.

    `effects new NAME --from DIR` writes a plugin that tests the dependence that `diagnose` found and no effect
    of the catalogue explains, and adds it to campaign.toml; it runs once you trust it.

    Example: stiffcal effects backlash -o backlash.svg
    """
    with answering(as_json) as answer:
        if name == "new":
            _write_new(answer, new_name, source, output)
            return OK
        if new_name is not None:
            reason, mend = "goes with new only", "write: effects new NAME --from DIR"
            raise InputError.at(FaultCode.OPTION_CONFLICT, "command line", "NEW_NAME", reason, mend)
        from stiffcal.commands.effects import code_of_campaign, describe_effects

        if output is not None and name is None:
            raise InputError.at(
                FaultCode.OPTION_CONFLICT,
                "command line",
                "-o",
                "a picture is of one effect",
                "name it: effects NAME -o FILE",
            )
        plugins = None if source is None else code_of_campaign(source)
        result = describe_effects(name, plugins)
        if name is None:
            answer.give(result, show_catalogue, NextLine("stiffcal effects joint-compliance"))
            return OK
        from stiffcal.report.effect_pictures.drawing import draw_effect, sketch_effect

        result = replace(result, sketch=sketch_effect(name, plugins))
        if output is not None:
            result = replace(result, picture=str(output), drawn=draw_effect(name, output, plugins, overwrite=overwrite))
        # Split before the answer is made fit for a terminal: that puts every text on one line.
        sections = [(title, escaped(text)) for title, text in sections_of(result.effects[0].physics)]
        page = partial(show_effect, sections=sections)
        answer.give(result, page, _of_campaign(source or HERE))
    return OK


def _of_campaign(folder: Path) -> NextLine:
    """Return the step that a campaign calls for, where the folder holds one that can be read."""
    try:
        return following(folder, None)
    except InputError:
        return NextLine("stiffcal diagnose DIR", once="there is a campaign")


def _write_new(answer: Answer, name: str | None, source: Path | None, output: Path | None) -> None:
    """Write an effect that tests what a diagnosis found."""
    from stiffcal.commands.new_effect import write_new_effect
    from stiffcal.stages.steps import RunContext

    if name is None or source is None:
        place = "NAME" if name is None else "--from"
        mend = "write: effects new NAME --from DIR"
        raise InputError.at(FaultCode.OPTION_MISSING, "command line", place, "is missing", mend)
    if output is not None:
        reason = "no picture is drawn of a new effect"
        raise InputError.at(FaultCode.OPTION_CONFLICT, "command line", "-o", reason, "leave -o out")
    context = RunContext(progress=answer.progress, notify=answer.notify)
    result = write_new_effect(source, name, context)
    then = NextLine(command_line("trust", source), once=f"you have read {result.file}")
    answer.show(result, then)


def show_catalogue(console: Console, result: EffectsResult) -> None:
    """Draw the list."""
    table = plain_table("name", "place", "what it is")
    for effect in result.effects:
        table.add_row(effect.name, effect.place, effect.summary)
    console.print(table)


def show_effect(console: Console, result: EffectsResult, sections: list[tuple[str, str]]) -> None:
    """Write one effect as a page of a textbook.

    Parameters
    ----------
    sections : (heading, text) of its description, as `sections_of` returns them.
    """
    (effect,) = result.effects
    width = min(console.width, WIDEST)

    def heading(text: str) -> None:
        console.print(f"\n{text}", style="bold", markup=False, highlight=False)

    def body(text: str, indent: str = "  ", following: str | None = None) -> None:
        filled = textwrap.fill(
            " ".join(text.split()), width, initial_indent=indent, subsequent_indent=following or indent
        )
        console.print(filled, soft_wrap=True, markup=False, highlight=False)

    console.print(f"{effect.name}: {effect.summary}", style="bold", soft_wrap=True, markup=False, highlight=False)
    for title, text in sections:
        heading(title)
        equation, separator, words = text.partition(", with ")
        if title == HEADINGS["law"] and separator and len(equation) < width - 10:
            body(equation, " " * 6)
            text = f"with {words}"
        body(text)
    heading("Places")
    words, option = PLACES.get(effect.place, (effect.place, ""))
    body(f"{words}; {ACTS.get(effect.kind, effect.kind)}")
    body(f"stiffcal add DIR {effect.name} {option}".rstrip(), " " * 6)
    if effect.parameters:
        heading("Parameters")
    for parameter in effect.parameters:
        body(f"{parameter.symbol} [{parameter.unit}]  {parameter.meaning}", following=" " * 6)
        low, high = (significant(bound) if bound is not None else "∞" for bound in parameter.bounds)
        low = "−∞" if parameter.bounds[0] is None else low
        body(f"possible {low} … {high}, typical {significant(parameter.typical)}", " " * 6)
        body(f"from: {parameter.source}", " " * 6)
    for title, text in _facts(effect):
        heading(title)
        body(text)
    if result.sketch:
        heading("Picture")
        for line in result.sketch:
            console.print(f"  {line}", soft_wrap=True, markup=False, highlight=False)
    if result.picture is not None:
        body(f"{result.picture}: {result.drawn}")


def sections_of(physics: str) -> list[tuple[str, str]]:
    r"""Return (heading, text) of an effect's description: its paragraphs, by the word that each begins with.

    Examples
    --------
    >>> sections_of("A drive gives.\n\nLaw: δ = c τ.\n\nLimits: small loads.")
    [('Physics', 'A drive gives.'), ('Law', 'δ = c τ.'), ('Where it ends', 'Small loads.')]
    >>> sections_of("Limits: c may be negative.")
    [('Where it ends', 'c may be negative.')]
    """
    sections: list[tuple[str, str]] = []
    for paragraph in physics.split("\n\n"):
        text = " ".join(paragraph.split())
        first = text.split(" ", 1)[0].rstrip(":,").lower()
        title = HEADINGS.get(first, sections[-1][0] if sections else "Physics")
        opening, _, rest = text.partition(" ")
        if first in HEADINGS and opening[-1] in ":,":
            # A law begins with its equation; there and in "c may be negative" letters are symbols and stay as they are.
            symbol = re.match(r"(?!a )[^\W\d_][²³ ]", rest)
            text = rest if opening == "Law:" or symbol else rest[:1].upper() + rest[1:]
        if sections and sections[-1][0] == title:
            text = f"{sections.pop()[1]} {text}"
        sections.append((title, text))
    return sections


def _facts(effect: EffectDescription) -> list[tuple[str, str]]:
    """Return the other sections of a page, without the empty ones."""
    included = ", ".join(effect.includes)
    excluded = ", ".join(effect.excludes)
    rows = (
        ("Needs", "; ".join(effect.needs) or "load states in several poses, nothing else"),
        ("Holds already", included and f"{included}: not next to it at the same place"),
        ("Not together with", excluded),
        ("Fingerprint", effect.fingerprint),
        ("Looks like", ", ".join(effect.looks_like)),
        ("How to check it on the machine", effect.check),
    )
    return [(title, text) for title, text in rows if text]
