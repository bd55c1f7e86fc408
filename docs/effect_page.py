"""The reference pages of effects, one each: law as formulas, picture, parameters, limits; and the list of all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from docs.expansions import PICTURES, figure
from docs.formulas import leading_formulas, mathml
from docs.markdown import cell, code, table
from docs.page_runs import AS_SHOWN, BLANK_SVG, digest_of_code
from stiffcal.commands.effects import describe_effects
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.report.effect_pictures.drawing import draw_effect
from stiffcal.results.command_results import EffectDescription
from stiffcal.show.answers.effects import ACTS, PLACES, sections_of

IN_MOTION = "torque in motion"
GROUPS = {
    "joints": "Effects of a joint",
    IN_MOTION: "Friction of a moving joint",
    "pairs": "Effects between two joints",
    "links": "Effects of a link",
    "set-up": "Effects of the set-up",
}
"""Kind or place of an effect to the heading of its part of the list."""


def effect_list() -> str:
    """The catalogue of effects by their place, each with a link to its page."""
    effects = describe_effects().effects
    parts = [
        "# Effects\n",
        "What `model.toml` can hold, a page each. `stiffcal effects NAME` prints the same for one effect.\n",
        "That the load acts on the deformed robot is part of the model itself, not an effect.\n",
    ]
    groups: dict[str, list[EffectDescription]] = {}
    for effect in effects:
        groups.setdefault(IN_MOTION if effect.kind == IN_MOTION else effect.place, []).append(effect)
    for group, heading in GROUPS.items():
        rows = [
            (f"[{code(one.name)}](effects/{one.name}.md)", cell(one.summary), cell(one.fingerprint))
            for one in groups.pop(group)
        ]
        parts += [f"## {heading}\n", table(("name", "what it is", "fingerprint"), rows)]
    assert not groups
    pages = "\n".join(f"effects/{one.name}" for one in effects)
    parts.append(f"```{{toctree}}\n:hidden:\n\n{pages}\n```\n")
    return "\n".join(parts)


def effect_page(name: str) -> str:
    """Law, picture, parameters and limits of one effect."""
    (effect,) = describe_effects(name).effects
    return "\n".join(_paragraphs(effect))


def _paragraphs(effect: EffectDescription) -> Iterator[str]:
    """Yield the parts of the page on one effect."""
    words, option = PLACES[effect.place]
    yield f"# {effect.name}\n"
    yield cell(effect.summary[:1].upper() + effect.summary[1:]) + ".\n"
    yield f"**Place:** {words}; {ACTS[effect.kind]}.\n"
    yield f"```sh\n{f'stiffcal add DIR {effect.name} {option}'.rstrip()}\n```\n"
    for title, text in sections_of(effect.physics):
        yield from law_paragraphs(effect, text) if title == "Law" else (f"**{title}:** {cell(text)}\n",)
    picture = PICTURES / f"{effect.name}.svg"
    if draw_once(effect.name, picture):
        command = f"`stiffcal effects {effect.name} -o {effect.name}.svg`"
        yield figure(picture, f"The effect, enlarged, on a lever ({command}): {effect.fingerprint}.") + "\n"
    rows = [
        (code(one.symbol), cell(one.unit), cell(one.meaning), "–" if one.typical is None else f"{one.typical:g}",
         " … ".join("∞" if end is None else f"{end:g}" for end in one.bounds))
        for one in effect.parameters
    ]  # fmt: skip
    if rows:
        yield table(("parameter", "unit", "meaning", "typical", "bounds"), rows)
    if effect.needs:
        yield f"**Needs:** {cell(', '.join(effect.needs))}\n"
    for title, names in (
        ("Includes", effect.includes),
        ("Excludes", effect.excludes),
        ("Looks like", effect.looks_like),
    ):
        if names:
            yield f"**{title}:** {', '.join(f'[{name}]({name}.md)' for name in names)}\n"
    yield f"**Fingerprint:** {cell(effect.fingerprint)}.\n"
    yield f"**How to check:** {cell(effect.check)}\n"


def law_paragraphs(effect: EffectDescription, law: str) -> Iterator[str]:
    """Yield an effect's law: its equations as formulas, then its other words."""
    formulas, rest = leading_formulas(law, frozenset(one.symbol for one in effect.parameters))
    yield "**Law:**\n"
    for formula in formulas:
        yield f'<div class="equation">{mathml(formula)}</div>\n'
    yield cell(rest) + "\n"


def draw_once(name: str, picture: Path) -> bool:
    """Draw an effect's picture unless it is there and stiffcal's code is still the same; False where nothing shows.

    Of pages as they are shown (`page_runs.AS_SHOWN`) it is blank.
    """
    picture.parent.mkdir(parents=True, exist_ok=True)
    drawn_with = picture.with_suffix(".key")
    if os.environ.get(AS_SHOWN):
        drawn_with.unlink(missing_ok=True)  # the next build draws it
        picture.write_text(BLANK_SVG, encoding="utf-8")
        return True
    if not drawn_with.exists() or drawn_with.read_text(encoding="utf-8") != digest_of_code():
        picture.unlink(missing_ok=True)
        try:
            draw_effect(name, picture)
        except InputError as error:
            if error.code is not FaultCode.DATA_MISSING:
                raise
        drawn_with.write_text(digest_of_code(), encoding="utf-8")
    return picture.exists()
