"""The reference page of effects: laws as formulas, pictures, parameters, limits."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from docs.expansions import PICTURES, figure
from docs.formulas import leading_formulas, mathml
from docs.markdown import cell, code, table
from docs.page_runs import digest_of_code
from stiffcal.cli.effects import sections_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.workflow.command_results import EffectDescription
from stiffcal.workflow.effect_pictures import draw_effect
from stiffcal.workflow.effects import describe_effects


def effect_page() -> str:
    """The catalogue of effects: list, then law, picture, parameters and limits of each."""
    effects = describe_effects().effects
    rows = [(f"[{code(effect.name)}](#{effect.name})", effect.place, cell(effect.summary)) for effect in effects]
    parts = [
        "# Effects\n",
        "What `model.toml` can hold. `stiffcal effects NAME` prints the same for one effect.\n",
        "The pictures are those of `stiffcal effects NAME -o NAME.svg`: the effect, enlarged, on a lever.\n",
        "That the load acts on the deformed robot is part of the model itself, not an effect.\n",
        table(("name", "place", "what it is"), rows),
    ]
    for effect in effects:
        parts += effect_section(effect)
    return "\n".join(parts)


def effect_section(effect: EffectDescription) -> Iterator[str]:
    """Yield the section on one effect."""
    yield f"## {effect.name}\n"
    for title, text in sections_of(effect.physics):
        yield from law_paragraphs(effect, text) if title == "Law" else (f"**{title}:** {cell(text)}\n",)
    picture = PICTURES / f"{effect.name}.svg"
    if draw_once(effect.name, picture):
        yield figure(picture, f"`stiffcal effects {effect.name} -o {effect.name}.svg`: {effect.fingerprint}") + "\n"
    rows = [
        (code(one.symbol), cell(one.unit), cell(one.meaning), "–" if one.typical is None else f"{one.typical:g}",
         " … ".join("∞" if end is None else f"{end:g}" for end in one.bounds))
        for one in effect.parameters
    ]  # fmt: skip
    if rows:
        yield table(("parameter", "unit", "meaning", "typical", "bounds"), rows)
    for title, names in (
        ("Needs", effect.needs),
        ("Includes", effect.includes),
        ("Excludes", effect.excludes),
        ("Looks like", effect.looks_like),
    ):
        if names:
            yield f"**{title}:** {cell(', '.join(names))}\n"
    yield f"**Fingerprint:** {cell(effect.fingerprint)}\n"
    yield f"**How to check:** {cell(effect.check)}\n"


def law_paragraphs(effect: EffectDescription, law: str) -> Iterator[str]:
    """Yield an effect's law: its equations as formulas, then its other words."""
    formulas, rest = leading_formulas(law, frozenset(one.symbol for one in effect.parameters))
    yield "**Law:**\n"
    for formula in formulas:
        yield f'<div class="equation">{mathml(formula)}</div>\n'
    yield cell(rest) + "\n"


def draw_once(name: str, picture: Path) -> bool:
    """Draw an effect's picture unless it is there and stiffcal's code is still the same; False where nothing shows."""
    picture.parent.mkdir(parents=True, exist_ok=True)
    drawn_with = picture.with_suffix(".key")
    if not drawn_with.exists() or drawn_with.read_text(encoding="utf-8") != digest_of_code():
        picture.unlink(missing_ok=True)
        try:
            draw_effect(name, picture)
        except InputError as error:
            if error.code is not FaultCode.DATA_MISSING:
                raise
        drawn_with.write_text(digest_of_code(), encoding="utf-8")
    return picture.exists()
