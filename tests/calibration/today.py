"""The answer of the search that `stiffcal diagnose` makes today."""

from __future__ import annotations

import time

from stiffcal.diagnosis.search import search_missing
from stiffcal.diagnosis.suspects.find import find_suspects
from stiffcal.diagnosis.suspects.words import without_steps
from stiffcal.diagnosis.thresholds import MOST_ALTERNATIVES
from stiffcal.model.catalogue import built_in_effects
from tests.calibration.answers import Answer, Named, name_of
from tests.calibration.field_mix import FieldCampaign
from tests.rates.scoring import is_firm

NAN = float("nan")


def judge(campaign: FieldCampaign) -> Answer:
    """Look for suspects, then for what is missing without them, as `stiffcal diagnose` does."""
    start = time.process_time()
    suspicion = find_suspects(campaign.states, campaign.model)
    firm = without_steps(suspicion)
    sound = campaign.states.select(firm.keep(campaign.states)) if firm.suspects else campaign.states
    search = search_missing(sound, campaign.model, built_in_effects())
    named = [
        Named(
            tuple(
                name_of(candidate.effect.name, candidate.place.label)
                for candidate in (one.candidate, *one.alternatives[:MOST_ALTERNATIVES])
            ),
            NAN, (), is_firm(search),
        )
        for one in search.found
    ]  # fmt: skip
    if search.undecided:
        rivals = [rival.candidate for rival in search.undecided]
        named.append(Named(tuple(name_of(one.effect.name, one.place.label) for one in rivals), NAN, (), False))
    return Answer(
        tuple(named), search.unexplained, tuple(one.run for one in suspicion.suspects), NAN, NAN,
        time.process_time() - start,
    )  # fmt: skip
