"""The answer of the one distribution over sets (`stiffcal.judgement`)."""

from __future__ import annotations

import time

from stiffcal.judgement.reading import read_off
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.answers import Answer, Named
from tests.calibration.field_mix import FieldCampaign

ALTERNATIVES = 0.95
"""Names are given until together they have so much of their group."""


def judge(campaign: FieldCampaign) -> Answer:
    """Weigh all sets of effects and unlisted laws, and read the answer off."""
    start = time.process_time()
    reading = read_off(judge_states(campaign.states, campaign.model, built_in_effects()))
    named = []
    for group in reading.groups:
        reached, names, shares = 0.0, [], []
        for name, share in group.members:
            names.append(name)
            shares.append(share)
            reached += share
            if reached >= ALTERNATIVES:
                break
        named.append(Named(tuple(names), group.probability, tuple(shares), group.firm))
    doubted = tuple(off.run for off, _ in reading.doubted if off.state is None)
    seconds = time.process_time() - start
    return Answer(tuple(named), reading.unexplained, doubted, reading.p_nothing, reading.p_unknown, seconds)
