"""What each effect makes of the deflection."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from stiffcal.identification.answers.deflection_shares import deflection_shares
from stiffcal.identification.readings.observations import observe
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.model.forms import form_of
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.simulated_states import medium_robot, played
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


def test_a_law_without_an_amplitude_has_its_share_too() -> None:
    """A spring as torque over angle, p1 = 1/c, is the spring of compliance c: what it makes of the deflection stays."""
    springs = medium_robot()
    law = form_of(find_effects()["cubic-stiffness"], ("p1", "p2", "p3"))
    cubic = PlacedEffect(law, Place("joints", (2,)), {"p1": SIX_STIFFNESS[1], "p2": 0.0, "p3": 0.0})
    by_angle = replace(springs, placed=(springs.placed[0], cubic, *springs.placed[2:]))
    observations = observe(played(springs, runs=3), springs.chain)
    linear, curved = (
        [entry.share for entry in deflection_shares(robot, observations)] for robot in (springs, by_angle)
    )
    assert linear[1] > 0.05
    assert curved == pytest.approx(linear, rel=1e-6)
