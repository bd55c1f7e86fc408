"""`stiffcal remove`: take an effect out of model.toml."""

from __future__ import annotations

from stiffcal.cli.add import EffectName, Everywhere, Model, edit
from stiffcal.cli.options import AsJson, Joints, Links, Pairs


def remove(
    folder: Model,
    effect: EffectName,
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
    return edit(folder, "remove", effect, {"joints": joints, "links": links, "pairs": pairs}, everywhere, as_json)
