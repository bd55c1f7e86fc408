"""The answer of the one distribution over sets (`stiffcal.judgement`)."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Mapping

import numpy as np

from stiffcal.judgement.evidence import Key
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.numbers import NAMED
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.reading import WhatIsMissing, read_off
from stiffcal.judgement.sensitivity import varied
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.answers import LEAST, Answer, Named
from tests.calibration.field_mix import FieldCampaign

ALTERNATIVES = 0.95
"""Names are given until together they have so much of their group."""


def judge(campaign: FieldCampaign) -> Answer:
    """Weigh all sets of effects and unlisted laws, and read the answer off."""
    start = time.process_time()
    judged = judge_states(campaign.states, campaign.model, built_in_effects())
    reading = read_off(judged)
    off: dict[str, tuple[int, ...]] = {one.name: tuple(o.run for o in one.off) for one in judged.members}
    named = []
    for group in reading.groups:
        names, shares = (list(part) for part in zip(*group.members, strict=True))
        given = 1 + int(np.searchsorted(np.cumsum(shares), ALTERNATIVES))
        runs = {run for name in names for run in off[name]}
        named.append(
            Named(
                tuple(names[:given]), group.probability, tuple(shares[:given]), group.firm,
                tuple(names[given:]), tuple(sorted(runs)),
            )
        )  # fmt: skip
    doubted = tuple(off.run for off, _ in reading.doubted if off.state is None)
    seconds = time.process_time() - start
    hangs_on = priors_that_decide(judged, reading)
    return Answer(
        tuple(named), reading.unexplained, doubted, reading.p_nothing, reading.p_unknown, seconds, hangs_on=hangs_on,
        effects={name: p for name, p in reading.probability.items() if p >= LEAST},
    )  # fmt: skip


def priors_that_decide(judged: Judged, reading: WhatIsMissing) -> tuple[str, ...]:
    """Return the priors that, three times larger or smaller, change what is named or that a law of no catalogue is."""
    groups = [{name for name, _ in group.members} for group in reading.groups]

    def verdict(sets: Mapping[Key, float]) -> tuple[bool, ...]:
        names = {key: {judged.members[i].name for i in key} for key in sets}
        kinds = {key: {judged.members[i].kind for i in key} for key in sets}
        of_group = [sum(p for key, p in sets.items() if names[key] & group) for group in groups]
        alone: dict[str, float] = defaultdict(float)
        for key, p in sets.items():
            for name in {judged.members[i].name for i in key if judged.members[i].kind is MemberKind.EFFECT}:
                alone[name] += p
        others = any(p >= NAMED for name, p in alone.items() if not any(name in group for group in groups))
        unlisted = sum(p for key, p in sets.items() if MemberKind.UNLISTED in kinds[key])
        return (*(p >= NAMED for p in of_group), others, unlisted >= NAMED)

    plain = verdict(judged.weighed.probabilities())
    return tuple(sorted({one.prior for one in varied(judged) if verdict(one.sets) != plain}))
