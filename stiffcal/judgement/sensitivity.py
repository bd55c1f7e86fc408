"""How a distribution over sets moves when any of the priors is taken three times larger or smaller.

A name that hangs on a prior is not firm: nobody knows a prior to a factor of three.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stiffcal.judgement.covariance_kind import CovarianceKind
from stiffcal.judgement.evidence import Key, MemberColumns, SetEvidence
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.members import Member
from stiffcal.judgement.numbers import PRIOR_FACTOR, VARIED_WITHIN
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.sets import normalised


class Varied(NamedTuple):
    """What a prior that is larger or smaller makes of a distribution."""

    prior: str
    """Which, in words."""
    factor: float
    """By which it is multiplied."""
    sets: Mapping[Key, float]
    """Probabilities of all sets."""


_ODDS = {
    "effects and laws that are expected": {MemberKind.EFFECT, MemberKind.UNLISTED},
    "laws of no catalogue": {MemberKind.UNLISTED},
    "mistakes in runs and readings": {MemberKind.MISTAKE, MemberKind.ROW},
    "mistakes in set-up and settings": {MemberKind.SETUP, MemberKind.SETTING},
}
"""Kinds of members that are more or less probable together."""


def varied(judged: Judged) -> Iterator[Varied]:
    """Give the probabilities of all sets, one prior after the other taken larger and smaller."""
    for factor in (PRIOR_FACTOR, 1.0 / PRIOR_FACTOR):
        for vary in (_odds_varied, _discrepancy_varied, _sizes_varied):
            for prior, sets in vary(judged, factor):
                yield Varied(prior, factor, sets)


_OfPrior = tuple[str, Mapping[Key, float]]


def _odds_varied(judged: Judged, factor: float) -> Iterator[_OfPrior]:
    """Vary how many effects are expected, how many laws that nobody has written down, and how many runs are off."""
    more = float(np.log(factor))
    for prior, kinds in _ODDS.items():
        yield (
            prior,
            normalised(
                {
                    key: value + more * sum(judged.members[i].kind in kinds for i in key)
                    for key, value in judged.weighed.log.items()
                }
            ),
        )


def _discrepancy_varied(judged: Judged, factor: float) -> Iterator[_OfPrior]:
    """Vary how probable each discrepancy is, and each way in which noise errs together."""
    ground = judged.ground
    kinds: dict[str, CovarianceKind | None] = {
        "discrepancy of loads": ground.of_loads,
        "discrepancy of time": ground.of_time,
        "noise that lingers": ground.lingering,
        "like states of sweeps": ground.alike,
    }
    for prior, kind in kinds.items():
        if kind is None:
            continue
        log = {}
        for key, values in judged.weighed.by_discrepancy.items():
            changed = values.copy()
            changed[ground.shared.numbers_of(kind)] += np.log(factor)
            log[key] = float(np.logaddexp.reduce(changed))
        yield prior, normalised(log)


def _sizes_varied(judged: Judged, factor: float) -> Iterator[_OfPrior]:
    """Vary the typical size of effects, the sizes of unlisted laws, and how well stated noise is known."""
    evidence = judged.weighed.evidence
    sizes = {"size of effects": MemberKind.EFFECT, "size of laws of no catalogue": MemberKind.UNLISTED}
    for prior, kind in sizes.items():
        members = [_resized(one, factor if one.kind is kind else 1.0) for one in judged.members]
        yield prior, _weighed_anew(judged, replace(evidence, members=members))
    if 0.0 < evidence.noise.known < np.inf:
        noise = replace(evidence.noise, known=evidence.noise.known * factor)
        yield "stated noise", _weighed_anew(judged, replace(evidence, noise=noise))


def _resized(member: Member, factor: float) -> MemberColumns:
    return replace(member.columns, sizes=member.columns.sizes * factor)


def _weighed_anew(judged: Judged, evidence: SetEvidence) -> Mapping[Key, float]:
    """Return the probabilities of the nearest sets alone: what all gain is no change."""
    log = judged.weighed.log
    top = max(log.values())
    near = {key: value for key, value in log.items() if value > top - VARIED_WITHIN}
    return normalised(
        {key: value + evidence.normal(key) - judged.weighed.evidence.normal(key) for key, value in near.items()}
    )
