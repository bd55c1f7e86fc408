"""What the judgement says of a campaign's folder."""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.reading import WhatIsMissing, read_off
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import built_in_effects


def judged_in(folder: Path) -> Judged:
    """Return the judgement of a folder; places and clamped drives are load states too."""
    campaign = load_campaign(folder)
    states = reduce_campaign(campaign, no_progress).states
    return judge_states(states, placed_robot(campaign), built_in_effects())


def said_of(folder: Path) -> WhatIsMissing:
    """Return what it says."""
    return read_off(judged_in(folder))
