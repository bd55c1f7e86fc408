"""Parts of the answer of `diagnose` that are the same whatever was measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Literal

from stiffcal.diagnosis.answers.results import (
    ExcludedSizeAt,
    Explanation,
    Finding,
    LawCurveAt,
    LookAlike,
    ProposedEffect,
    SearchPace,
    UndecidedEffect,
    UnknownLaw,
)
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.lack_of_fit import family_p
from stiffcal.diagnosis.scans.ranking import effect_at, parameters_of, share_explained
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.identification.answers.document import finite
from stiffcal.judgement.excluded import ExcludedSize
from stiffcal.judgement.found import Diagnosed, FoundEffect
from stiffcal.judgement.numbers import DOUBT, MOST_UNDECIDED, NAMED
from stiffcal.judgement.reading import UnlistedFound
from stiffcal.judgement.sentences import why_not_added
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt, Where


def where_of(place: str) -> Where:
    """Return a place of the judgement's priors as one of a result; empty for the set-up.

    Examples
    --------
    >>> where_of("joint 3").joints, where_of("link swing").links
    ([3], ['swing'])
    """
    kind, _, name = place.partition(" ")
    if kind == "joint":
        return Where(joints=[int(name)])
    return Where(links=[name]) if kind == "link" and name else Where()


def proposed(effects: Sequence[FoundEffect]) -> list[ProposedEffect]:
    """Return effects that are there."""
    return [_proposed(one) for one in effects]


def _proposed(one: FoundEffect) -> ProposedEffect:
    """Return an effect to add."""
    at = effect_at(one.candidate)
    return ProposedEffect(
        effect=at.effect,
        where=at.where,
        alternatives=[
            LookAlike(effect=candidate.effect.name, where=Where.of(candidate.place), probability=share)
            for candidate, share in one.alternatives
        ],
        probability=one.group.probability,
        member_probability=one.share,
        firm=one.group.firm,
        form=dict(one.form) or None,
    )


def unknown_laws(found: Diagnosed, curve: Callable[[UnlistedFound], LawCurveAt | None]) -> list[UnknownLaw]:
    """Return the laws that nobody has written down and are probably there.

    Parameters
    ----------
    curve : gives the curve of a law over what it follows; None where it has none.
    """
    return [
        UnknownLaw(
            follows=law.follows,
            where=where_of(law.place),
            of=law.place,
            probability=law.probability,
            curve=curve(law),
        )
        for law in found.reading.unlisted
    ]


def excluded_sizes_of(
    found: Diagnosed, unit: Literal["m", "N·m"], deciding_force: Callable[[ExcludedSize], float | None]
) -> list[ExcludedSizeAt] | None:
    """Return what could not be excluded, in the unit of the readings; None where something is found.

    Parameters
    ----------
    deciding_force : gives the force that would show one as large as the noise; None where none would.
    """
    if found.found:
        return None
    entries = []
    for one in found.excluded:
        entry = ExcludedSizeAt(
            where=where_of(one.where),
            of=one.where,
            size_m=None,
            effect=one.effect.effect.name,
            deciding_force_N=deciding_force(one),
        )
        size = finite(one.size)
        entries.append(replace(entry, size_m=size) if unit == "m" else replace(entry, size_Nm=size))
    return entries


def superfluous_of(found: Diagnosed) -> list[EffectAt]:
    """Return the effects that the model has for nothing."""
    return [EffectAt(effect=one.effect.name, where=Where.of(one.place)) for one in found.superfluous]


def pace_of(found: Diagnosed) -> SearchPace:
    """Return how much was compared, and how fast."""
    n_effects, n_shapes = found.n_members
    rounds = found.judged.rounds
    return SearchPace(
        models=rounds,
        candidates=n_effects * rounds,
        signatures=n_shapes * rounds,
        seconds=found.seconds,
        candidates_per_second=n_effects * rounds / found.seconds,
    )


def candidates_of(found: Diagnosed) -> dict[str, Candidate]:
    """Return the effects at their places that were compared, by name."""
    return {one.name: one.candidate for one in found.judged.members if one.candidate is not None}


def undecided_effects(found: Diagnosed) -> list[UndecidedEffect]:
    """Return the effects of the first group in which none is more probable than all others together."""
    for one in found.found:
        if not one.decided:
            members = [(one.candidate, one.share), *one.alternatives][:MOST_UNDECIDED]
            return [
                UndecidedEffect(effect=at.effect, where=at.where, share=share, probability=share, deciding_runs=[])
                for candidate, share in members
                for at in (effect_at(candidate),)
            ]
    return []


def ranked_findings(
    found: Diagnosed,
    before: Rms,
    after_choosing: Rms,
    rms_after: Callable[[Trial], Rms],
    explain: Callable[[Trial, Rms, list[Candidate]], Explanation],
) -> Iterator[tuple[Trial, Finding]]:
    """Give every effect as the next single step: the most probable first, then those that lower the error most.

    Parameters
    ----------
    before : rms of what is left out, by the present model.
    after_choosing : the same with the choice itself repeated without each fold, for the first.
    rms_after : gives the rms of what is left out with an effect.
    explain : gives the words for an effect that is probable, with that rms and those that look the same.
    """
    probability, scan = found.reading.probability, found.first
    order = {trial.candidate.name: rank for rank, trial in enumerate(scan.trials)}
    named = {one.candidate.name: rank for rank, one in enumerate(found.found)}
    ranked = sorted(
        scan.trials,
        key=lambda trial: (
            named.get(trial.candidate.name, len(named)),
            -p if (p := probability.get(trial.candidate.name, 0.0)) >= DOUBT else 0.0,
            order[trial.candidate.name],
        ),
    )
    alike = {one.candidate.name: [candidate for candidate, _ in one.alternatives] for one in found.found}
    for rank, trial in enumerate(ranked):
        name = trial.candidate.name
        after = rms_after(trial)
        alternatives = alike.get(name, [])
        p = probability.get(name, 0.0)
        explanation = explain(trial, after, alternatives) if name in named or p >= NAMED else None
        at = effect_at(trial.candidate)
        yield (
            trial,
            Finding(
                effect=at.effect,
                where=at.where,
                verdict="supported" if name in named else "possible" if p >= DOUBT else "rejected",
                explains=share_explained(scan, trial),
                size_m=None,
                p_value=family_p(scan, trial),
                heldout_rms_before=before,
                heldout_rms_after=after,
                heldout_rms_after_choosing=after_choosing if rank == 0 else None,
                confidence=None,
                probability=p,
                parameters=parameters_of(trial),
                alternatives=[effect_at(candidate) for candidate in alternatives],
                why=explanation.text if explanation is not None else why_not_added(p),
                evidence=explanation,
            ),
        )
