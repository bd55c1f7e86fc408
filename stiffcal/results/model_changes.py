"""Which changes of the model a diagnosis calls for: what is added, what is taken out again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect
from stiffcal.diagnosis.words import effect_in_words
from stiffcal.model.summary import EffectAt, Where
from stiffcal.results.improve_results import ImproveStep
from stiffcal.wording import listing

LIKELY = 0.5
"""Share of its group from which an effect that is not certain is added where that is asked for."""

Change = Literal["add", "remove"]
Made: TypeAlias = tuple[Change, str, Where]
"""A change, the effect and its place."""
Decision = Literal["yes", "skip", "stop"] | EffectAt
"""What to do with a proposal: make it, leave it and go on with the next, end, or add this effect in its place."""


@dataclass(frozen=True, slots=True)
class EffectProposal:
    """A change of the model, before it is made."""

    change: Change
    effect: ProposedEffect | EffectAt
    """What is to be added or removed, and where."""
    diagnosed: DiagnoseResult
    """The diagnosis that calls for it."""


def to_add(diagnosed: DiagnoseResult, likely: bool) -> list[ProposedEffect]:
    """Return what is to be added: what is certain, and what is probable where that is asked for.

    Effects of one distribution are missing together.
    """
    undecided = [(one.effect, one.where) for one in diagnosed.undecided]
    return [
        effect
        for effect in diagnosed.missing
        if effect.firm
        or (likely and (effect.member_probability or 0.0) >= LIKELY and (effect.effect, effect.where) not in undecided)
    ]


def next_changes(
    diagnosed: DiagnoseResult, skipped: Sequence[Made], added: Sequence[Made], likely: bool
) -> list[tuple[Change, ProposedEffect | EffectAt]]:
    """Return the next changes of the model that a diagnosis calls for.

    Parameters
    ----------
    skipped : what was declined. added : what was added before: nothing else is taken out again.
    likely : whether what is probable and not certain is added too.
    """
    new = [one for one in to_add(diagnosed, likely) if ("add", one.effect, one.where) not in skipped]
    if new:
        return [("add", effect) for effect in new]
    # With something still missing, an effect may only seem unnecessary.
    if diagnosed.undecided or diagnosed.missing:
        return []
    return [
        ("remove", one)
        for one in diagnosed.superfluous
        if ("add", one.effect, one.where) in added and ("remove", one.effect, one.where) not in skipped
    ]


def removed_in_words(steps: Sequence[ImproveStep]) -> str:
    """Return what the removal of effects does not show, as a sentence to append; "" where none was removed.

    Examples
    --------
    >>> unknown = {"heldout_rms": None, "noise": None}
    >>> places = [Where(joints=[joint]) for joint in (2, 4)]
    >>> tilts = [ImproveStep(action="remove", effect="bearing-tilt", where=where, **unknown) for where in places]
    >>> removed_in_words(tilts).partition(".")[0]
    ' Removed, as held-out poses show no larger error without: bearing-tilt of joints 2, 4'
    """
    places: dict[str, dict[str, list[Any]]] = {}
    for step in steps:
        if step.action == "remove" and step.effect is not None:
            where = places.setdefault(step.effect, {})
            for kind, items in step.where.items():
                where.setdefault(kind, []).extend(items)
    if not places:
        return ""
    removed = [EffectAt(effect=effect, where=Where(**where)) for effect, where in places.items()]
    return (
        f" Removed, as held-out poses show no larger error without: {' and '.join(map(effect_in_words, removed))}. "
        "That these data cannot distinguish them from zero does not show that they are zero."
    )


def not_added_in_words(diagnosed: DiagnoseResult) -> str:
    """Return what is missing and was not added because it is not certain, as a sentence to append; "" for nothing.

    Parameters
    ----------
    diagnosed : the last diagnosis, after which what is certain was added.
    """
    probable = to_add(diagnosed, likely=True)
    uncertain = [effect for effect in diagnosed.missing if not effect.firm]
    if not uncertain:
        return ""

    def in_words(effects: Sequence[ProposedEffect]) -> str:
        return listing(effect_in_words(EffectAt(effect=one.effect, where=one.where)) for one in effects)

    them = "it" if len(uncertain) == 1 else "them"
    added = [effect for effect in uncertain if effect in probable]
    if not added:
        how = f"--likely does not add {them} either: no look-alike is more probable than the others together"
    else:
        how = f"--likely adds {them if len(added) == len(uncertain) else in_words(added)}"
    return f" Not added, as not certain: {in_words(uncertain)}; {how}."


def planned_steps(diagnosed: DiagnoseResult, likely: bool) -> list[ImproveStep]:
    """Return the steps that a diagnosis calls for: nothing is changed, so nothing is known of the error."""
    return [
        ImproveStep(
            action="would add",
            effect=effect.effect,
            where=effect.where,
            heldout_rms=None,
            noise=None,
            probability=effect.probability,
            firm=effect.firm,
        )
        for effect in to_add(diagnosed, likely)
    ]
