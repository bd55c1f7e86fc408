"""A model, and what changes from one to the next, in words."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.model.summary import EffectInModel, ModelSummary
from stiffcal.wording import place

STEPS = {
    "nominal": "nominal robot",
    "frames": "+ frames",
    "offsets": "+ joint offsets",
    "geometry": "+ geometry",
    "springs": "+ joint-compliance",
    "model": "+ other effects",
}
"""Steps of the ladder from the nominal robot to the present model, as they are printed."""


def _effect(entry: EffectInModel) -> str:
    where = dict(entry.where.items())
    return f"{entry.type} ({place(where)})" if where else entry.type


def model_change(before: ModelSummary, after: ModelSummary) -> str:
    """Write what a model gained (+) and lost (−) against the one before, "" where it is the same.

    Examples
    --------
    >>> springs = EffectInModel("joint-compliance", joints=[1, 2])
    >>> one = ModelSummary("deformed", [springs])
    >>> two = ModelSummary("deformed", [springs, EffectInModel("backlash", joints=[4])])
    >>> model_change(one, two), model_change(two, one), model_change(one, one)
    ('+ backlash (joint 4)', '− backlash (joint 4)', '')
    >>> model_change(ModelSummary("deformed", []), one)
    '+ joint-compliance (joints 1, 2)'
    """
    old, new = _single_places(before), _single_places(after)
    gained = [f"+ {text}" for text in _of_all_places([effect for effect in new if effect not in old])]
    lost = [f"− {text}" for text in _of_all_places([effect for effect in old if effect not in new])]
    return "; ".join([*gained, *lost])


def _of_all_places(singles: Sequence[EffectInModel]) -> list[str]:
    """Write effects of single places, each effect once with all of its places."""
    entries: dict[str, EffectInModel] = {}
    for one in singles:
        entry = entries.get(one.type, EffectInModel(one.type))
        entries[one.type] = EffectInModel(
            one.type,
            joints=[*(entry.joints or []), *(one.joints or [])] or None,
            links=[*(entry.links or []), *(one.links or [])] or None,
            pairs=[*(entry.pairs or []), *(one.pairs or [])] or None,
        )
    return [_effect(entry) for entry in entries.values()]


def _single_places(model: ModelSummary) -> list[EffectInModel]:
    """List a model's effects place by place."""
    effects: list[EffectInModel] = []
    for entry in model.effects:
        single = [
            *(EffectInModel(entry.type, joints=[joint]) for joint in entry.joints or []),
            *(EffectInModel(entry.type, links=[link]) for link in entry.links or []),
            *(EffectInModel(entry.type, pairs=[pair]) for pair in entry.pairs or []),
        ]
        effects += single or [entry]
    return effects


def model_words(model: ModelSummary) -> str:
    """Write a model as one phrase.

    Examples
    --------
    >>> model_words(ModelSummary("deformed", [EffectInModel("backlash", joints=[4]), EffectInModel("base-offset")]))
    'backlash (joint 4) + base-offset'
    """
    first_order = ", first-order balance" if model.balance == "first-order" else ""
    return (" + ".join(_effect(entry) for entry in model.effects) or "no effect") + first_order
