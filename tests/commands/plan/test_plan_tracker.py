"""Where the tracker of a plan stands: from plan.toml, else from campaign.toml."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.planning.campaign.tracker import tracker_of, tracker_warnings

KR240 = Path(__file__).parents[3] / "campaigns" / "kr240"
AXES = {"axis": (-1.0, 0.0, 0.0)}


@pytest.mark.parametrize(
    ("table", "place", "n_warnings"),
    [
        (AXES, (3.6, -1.4, 0.5), 0),
        ({}, (3.6, -1.4, 0.5), 1),
        ({**AXES, "position_m": (3.6, -1.4, 0.55)}, (3.6, -1.4, 0.55), 0),
        ({**AXES, "position_m": (3.6, 1.4, 0.5)}, (3.6, 1.4, 0.5), 1),
    ],
)
def test_the_place_is_that_of_the_frame_unless_the_plan_has_one(
    table: dict[str, object], place: tuple[float, ...], n_warnings: int
) -> None:
    campaign = load_campaign(KR240, check_files=False)
    plan = PlanFile.model_validate({"tracker": table})
    tracker = tracker_of(campaign, plan)
    assert tracker is not None
    np.testing.assert_allclose(tracker.position, place)
    assert len(tracker_warnings(campaign, plan)) == n_warnings
