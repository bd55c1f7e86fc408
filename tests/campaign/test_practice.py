"""The practice campaigns load as they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign

PRACTICE = Path(__file__).parents[3] / "shared" / "practice"


@pytest.mark.skipif(not PRACTICE.is_dir(), reason="the practice campaigns are not here")
def test_all_practice_campaigns_load() -> None:
    folders = sorted(path.parent for path in PRACTICE.glob("*/campaign.toml"))
    assert folders
    for folder in folders:
        campaign = load_campaign(folder)
        chain = campaign.chain
        setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
        assert setup.target_names == ("target",)
        assert chain.masses_known
        assert {"swing", "arm"} <= set(chain.beams)
