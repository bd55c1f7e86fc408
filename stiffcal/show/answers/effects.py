"""What `effects` shows: the catalogue, or one effect as a page of a textbook."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder
from stiffcal.wording import significant

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import EffectDescription, EffectsResult
    from stiffcal.show.options import ShowOptions

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
HEADINGS = {"law": "Law", "assumes": "Assumptions", "limits": "Where it ends"}
LONGEST_EQUATION = 70
"""Characters of an equation that stands on a line of its own."""


def page(result: EffectsResult, options: ShowOptions) -> Page:
    """Return the list; of one effect its physics, where it may be, its parameters, what it needs, how it looks."""
    if len(result.effects) != 1:
        made = PageBuilder("Effects")
        rows = [(effect.name, effect.place, effect.summary) for effect in result.effects]
        made.table(("name", "place", "what it is"), rows)
        return made.page()
    (effect,) = result.effects
    made = PageBuilder(effect.name)
    made.say(f"{effect.name}: {effect.summary}", "effect")
    for title, text in sections_of(effect.physics):
        made.head(title, is_title=True)
        made.list(_law(text) if title == HEADINGS["law"] else [text], "physics")
    made.head("Places", is_title=True)
    words, option = PLACES.get(effect.place, (effect.place, ""))
    line = f"{INDENT}stiffcal add DIR {effect.name} {option}".rstrip()
    made.list([f"{words}; {ACTS.get(effect.kind, effect.kind)}", line], "places")
    if effect.parameters:
        made.head("Parameters", is_title=True)
        made.list(_parameters(effect), "parameters")
    for title, text in _facts(effect):
        made.head(title, is_title=True)
        made.list([text], "fact")
    if result.sketch:
        made.head("Picture", is_title=True)
        made.list(result.sketch, "sketch")
    if result.picture is not None:
        made.list([f"{result.picture}: {result.drawn}"], "written")
    return made.page()


INDENT = " " * 4
"""Of what belongs to the line above it."""


def _law(text: str) -> list[str]:
    """Return a law with its equation, where that is short enough, apart."""
    equation, separator, words = text.partition(", with ")
    apart = bool(separator) and len(equation) < LONGEST_EQUATION
    return [f"{INDENT}{equation}", f"with {words}"] if apart else [text]


def _parameters(effect: EffectDescription) -> list[str]:
    texts = []
    for parameter in effect.parameters:
        low, high = (significant(bound) if bound is not None else "∞" for bound in parameter.bounds)
        low = "−∞" if parameter.bounds[0] is None else low
        texts += [
            f"{parameter.symbol} [{parameter.unit}] {parameter.meaning}",
            f"{INDENT}possible {low} … {high}, typical {significant(parameter.typical)}",
            f"{INDENT}from: {parameter.source}",
        ]
    return texts


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
