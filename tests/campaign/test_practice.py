"""The campaigns whose truth is known load as they are."""

from __future__ import annotations

import pytest

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from tests.laboratory.hidden_campaigns import NAMES, folder_of


@pytest.mark.parametrize("name", [*NAMES, "13-raw", "13-table"])
def test_campaigns_load(name: str) -> None:
    campaign = load_campaign(folder_of(name))
    chain = campaign.chain
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    assert setup.target_names == ("target",)
    assert chain.masses_known
    assert {"swing", "arm"} <= set(chain.beams)
