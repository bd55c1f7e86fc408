"""Which effects the page for a browser offers to add, and how sure the diagnosis is of each."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from stiffcal.diagnosis.answers.results import DiagnoseResult, Finding, LookAlike, ProposedEffect, UndecidedEffect
from stiffcal.diagnosis.words import effect_in_words
from stiffcal.escapes import shell
from stiffcal.model.summary import EffectAt
from stiffcal.show.excluded import excluded_in_words
from stiffcal.view.content import CandidateStanding, ViewCandidate
from stiffcal.view.gathering.models import place_words
from stiffcal.wording import probability_in_words

MOST_OFFERED = 24
"""Of candidates that are rejected only so many stand on the page: the answer of `diagnose --json` has all."""


def view_candidates(diagnosis: DiagnoseResult | None) -> list[ViewCandidate]:
    """Return the candidates of a diagnosis, the most likely first, each once."""
    if diagnosis is None:
        return []
    offered: dict[str, ViewCandidate] = {}
    stated = _stated(diagnosis)
    for standing, effect in _in_order(diagnosis):
        name = _name(effect)
        if name in offered or (standing == "rejected" and len(offered) >= MOST_OFFERED):
            continue
        finding = next(
            (one for one in diagnosis.findings if one.effect == effect.effect and one.where == effect.where), None
        )
        offered[name] = ViewCandidate(
            name=name,
            standing=standing,
            sure=_how_sure(stated.get(name), finding, standing),
            heldout_rms=None if finding is None else finding.heldout_rms_after,
            why="" if finding is None else finding.why,
            command=command_of("add", effect),
        )
    return list(offered.values())


def in_model_in_words(diagnosis: DiagnoseResult | None) -> str:
    """Return how sure a diagnosis is that effects of the model are there, with their look-alikes; "" of none."""
    texts = []
    for held in () if diagnosis is None else diagnosis.in_model or ():
        members: list[ProposedEffect | LookAlike] = [held, *held.alternatives]
        first, *others = (
            f"{effect_in_words(EffectAt(effect=one.effect, where=one.where))} "
            f"{probability_in_words(held.probability_of(one) or 0.0)}"
            for one in members
        )
        texts.append(first + (f" (cannot be distinguished from: {', '.join(others)})" if others else ""))
    return f"In the model: {'; '.join(texts)}." if texts else ""


def sizes_in_words(diagnosis: DiagnoseResult | None) -> str:
    """Return how large an effect would have been found, where a diagnosis finds none; "" where it finds one."""
    texts = [] if diagnosis is None else excluded_in_words(diagnosis)
    return " ".join(f"{text[0].upper()}{text[1:]}." for text in texts)


def _name(effect: EffectAt | ProposedEffect | LookAlike | UndecidedEffect) -> str:
    return f"{effect.effect} {place_words(effect.where)}"


def _stated(diagnosis: DiagnoseResult) -> dict[str, float]:
    """Return the probabilities of effects that the verdict names, by name: the ranking may lack some of them."""
    found = {}
    for missing in diagnosis.missing:
        members: list[ProposedEffect | LookAlike] = [missing, *missing.alternatives]
        for one in members:
            if (p := missing.probability_of(one)) is not None:
                found[_name(one)] = p
    return found


def _how_sure(stated: float | None, finding: Finding | None, standing: CandidateStanding) -> str:
    """Return how sure the diagnosis is of a candidate, in words; "" of what is rejected, and where it does not say."""
    probability = stated if stated is not None or finding is None else finding.probability
    return "" if standing == "rejected" or probability is None else probability_in_words(probability)


def _in_order(diagnosis: DiagnoseResult) -> Iterator[tuple[CandidateStanding, EffectAt]]:
    """Yield effects and how they stand: what is missing, with its look-alikes, undecided ones, the ranking."""
    for missing in diagnosis.missing:
        yield "missing", EffectAt(effect=missing.effect, where=missing.where)
        for alike in missing.alternatives:
            yield "alike", alike
    for one in diagnosis.undecided:
        yield "undecided", EffectAt(effect=one.effect, where=one.where)
    for other in diagnosis.could_be:
        yield "undecided", other
    for finding in sorted(diagnosis.findings, key=lambda finding: finding.verdict == "rejected"):
        yield (
            ("rejected" if finding.verdict == "rejected" else "possible"),
            EffectAt(effect=finding.effect, where=finding.where),
        )


def command_of(action: str, effect: EffectAt) -> str:
    """Return the line for a terminal that adds or removes an effect, in the campaign's folder.

    Examples
    --------
    >>> from stiffcal.model.summary import Where
    >>> command_of("add", EffectAt(effect="backlash", where=Where(joints=[4])))
    'stiffcal add . backlash --joints 4'
    """
    words = [
        word
        for kind, places in effect.where.items()
        for word in (f"--{kind}", ",".join(_place(place) for place in places))
    ]
    return shell.command_line(action, Path(), effect.effect, *words)


def _place(place: int | str | list[int]) -> str:
    return "-".join(map(str, place)) if isinstance(place, list) else str(place)
