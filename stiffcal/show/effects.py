"""Effects in words: with their places, as options, with their look-alikes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.wording import place, probability_in_words

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult, Finding, LookAlike, ProposedEffect
    from stiffcal.model.summary import EffectAt, Where
    from stiffcal.presentation.values import Level
    from stiffcal.results.improve_results import ImproveResult


def effect_words(effect: EffectAt | ProposedEffect | LookAlike | Finding) -> str:
    """Return an effect with its place."""
    return f"{effect.effect} ({place(effect.where)})"


def look_alike_words(of: ProposedEffect, effect: LookAlike) -> str:
    """Return a look-alike with its place and its probability."""
    return f"{effect_words(effect)} {probability_in_words(of.probability_of(effect) or 0.0)}"


def place_words(where: Where) -> list[str]:
    """Return the options that name a place.

    Examples
    --------
    >>> from stiffcal.model.summary import Where
    >>> place_words(Where(joints=[4]))
    ['--joints', '4']
    """
    texts = []
    for kind, items in where.items():
        names = ["-".join(str(member) for member in item) if isinstance(item, list) else str(item) for item in items]
        texts += [f"--{kind}", ",".join(names)]
    return texts


def diagnosis_level(diagnosed: DiagnoseResult | ImproveResult) -> Level:
    """Return how a diagnosis stands: pass where nothing is missing, warn where something is, or cannot be judged."""
    return "pass" if diagnosed.adequate and not diagnosed.missing else "warn"
