"""What each state carries stands in the table of held-out poses: branch, load, torque of every joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from stiffcal.campaign.frames.frames import resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.identification.readings.state_loads import force_since_reference
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.mechanics.kinematics import attached_poses
from tests.laboratory.small_campaign import LEVELS

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "absolute" / "02"


@pytest.fixture(scope="module")
def heldout(validated_folder: Path) -> pd.DataFrame:
    return pd.read_parquet(validated_folder / "store" / "current" / "unseen.parquet")


def test_loads_are_those_that_were_set_and_branches_follow_them(heldout: pd.DataFrame) -> None:
    """The campaign sets 150, 300, 150 and 0 N along three directions, each twice, from an unloaded reference."""
    first = heldout[heldout["run"] == "pose1"]
    size = np.sqrt(1.01)  # of the first direction, (1, 0.1, 0)
    assert first["load_N"].to_numpy()[:5] == pytest.approx(size * np.array(LEVELS), abs=1e-6)
    assert first["branch"].iloc[:5].tolist() == ["", "loading", "loading", "unloading", ""]


def test_the_torque_of_joint_1_is_the_moment_of_the_load_about_its_axis(
    heldout: pd.DataFrame, validated_folder: Path
) -> None:
    """Joint 1 turns about the base's z axis, so that weight does nothing to it: τ = x Fy − y Fx."""
    campaign = load_campaign(validated_folder)
    frames = resolve_frames(campaign.manifest, campaign.chain)
    raw = pd.read_csv(validated_folder / "raw" / "states.csv")
    angles = np.radians(raw[[f"A{k}" for k in range(1, 7)]].to_numpy())
    point, _ = attached_poses(campaign.chain, campaign.chain.model_angles(angles), frames["load_point"])
    moment = point[:, 0] * raw["Fy"] - point[:, 1] * raw["Fx"]
    assert heldout["tau_1_Nm"].to_numpy() == pytest.approx(
        moment.to_numpy(), rel=0.01, abs=300.0 * 4e-3
    )  # it gives by millimetres
    assert {f"tau_{k}_Nm" for k in range(1, 7)} <= set(heldout.columns)


def test_the_load_of_an_absolute_row_is_the_whole_payload() -> None:
    """Each row is its own reference: less that, every load would be zero."""
    campaign = load_campaign(CAMPAIGN)
    states = reduce_campaign(campaign, no_progress).states
    payload = pd.read_csv(CAMPAIGN / "raw" / "poses.csv")["payload_kg"].to_numpy()
    assert payload.max() > 0.0
    force = np.linalg.norm(force_since_reference(states, campaign.chain), axis=1)
    assert force == pytest.approx(payload * np.linalg.norm(campaign.chain.gravity), abs=1e-9)
