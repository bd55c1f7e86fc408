"""What each effect makes of the deflection."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.identification.deflection_shares import deflection_shares
from stiffcal.identification.readings import observe
from stiffcal.model.campaign_effects import placed_robot
from stiffcal.workflow.identify import up_to_date_fit
from stiffcal.workflow.steps import RunContext, up_to_date_states
from tests.laboratory.small_campaign import write_small_campaign


def test_shares_add_up_and_follow_the_stiffness(tmp_path: Path) -> None:
    """Half the stiffness of a joint doubles what it makes; all parts together are the whole deflection."""
    data = up_to_date_states(write_small_campaign(tmp_path / "c", poses=4), RunContext())
    robot = placed_robot(data.campaign).with_values(up_to_date_fit(data, RunContext()).values())
    observations = observe(data.states, robot.chain)
    shares = {entry.placed.place.label: entry.share for entry in deflection_shares(robot, observations)}
    # the balance is that of the deformed robot, so that the parts add up to first order only
    assert sum(shares.values()) == pytest.approx(1.0, abs=0.01)
    softer = robot.with_values({"joint-compliance.j2.c": 2.0 * robot.values()["joint-compliance.j2.c"]})
    changed = {entry.placed.place.label: entry.share for entry in deflection_shares(softer, observations)}
    assert changed["j2"] / changed["j1"] > 1.5 * shares["j2"] / shares["j1"]
