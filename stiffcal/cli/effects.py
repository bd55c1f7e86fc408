"""`stiffcal effects`: the catalogue of physical effects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import significant

if TYPE_CHECKING:
    from rich.console import Console


def effects(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="One effect in full.", show_default=False)] = None,
    as_json: AsJson = False,
) -> int:
    """List the physical effects, or explain one.

    With a name: physics, places, parameters with units, what it needs and what looks like it.

    Example: stiffcal effects joint-compliance
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.effects import describe_effects

        document = describe_effects(name)
        if name is None:
            answer.give(document, show_catalogue, "stiffcal effects joint-compliance")
        else:
            answer.give(document, show_effect, command_line("add", HERE, ".", name, "--all"))
    return OK


def show_catalogue(console: Console, document: Document) -> None:
    """Draw the list."""
    table = plain_table("name", "place", "what it is")
    for effect in document["effects"]:
        table.add_row(effect["name"], effect["place"], effect["summary"])
    console.print(table)


def show_effect(console: Console, document: Document) -> None:
    """Draw one effect."""
    (effect,) = document["effects"]
    console.print(f"{effect['name']} ({effect['place']})\n")
    for paragraph in effect["physics"].split("\n\n"):
        console.print(" ".join(paragraph.split()) + "\n")
    table = plain_table("parameter", "unit", "meaning", "bounds", "typical>", "from")
    for parameter in effect["parameters"]:
        low, high = parameter["bounds"]
        bounds = f"{significant(low) if low is not None else '−∞'} … {significant(high) if high is not None else '∞'}"
        words = (parameter["symbol"], parameter["unit"], parameter["meaning"], bounds)
        table.add_row(*words, significant(parameter["typical"]), parameter["source"])
    console.print()
    console.print(table)
    console.print()
    for key, title in (
        ("needs", "needs"),
        ("includes", "includes"),
        ("excludes", "excludes"),
        ("fingerprint", "fingerprint"),
        ("looks_like", "looks like"),
        ("check", "on the machine"),
    ):
        value = effect[key]
        if value:
            console.print(f"{title}: {', '.join(value) if isinstance(value, list) else value}")
