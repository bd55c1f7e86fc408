"""Absolute places and clamped joints, judged by what judges load states: bundled campaigns of another simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.judgement.numbers import FIRM
from tests.laboratory.judged_folder import said_of

pytestmark = pytest.mark.long

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


def test_nothing_is_named_where_geometry_and_springs_explain_all() -> None:
    found = said_of(CAMPAIGNS / "absolute/01")
    assert found.groups == ()
    assert found.doubted == ()
    assert found.p_nothing > 0.9


@pytest.mark.parametrize(
    ("name", "effect"),
    [
        ("absolute/02", "bearing-tilt j2"),
        ("absolute/04", "joint-eccentricity j1"),
        ("joints/02", "backlash j1"),
        ("joints/03", "friction-hysteresis j1"),
    ],
)
def test_what_is_hidden_is_named_and_firm(name: str, effect: str) -> None:
    (group,) = said_of(CAMPAIGNS / name).groups
    assert group.members[0][0] == effect
    assert group.firm


def test_what_turning_points_are_off_by_is_probably_no_law_of_its_own() -> None:
    """It lasts as long as friction holds. All runs take part: two were set aside for an exchange, and then sound."""
    found = said_of(CAMPAIGNS / "joints/03")
    (group,) = found.groups
    assert group.members[0][0] == "friction-hysteresis j1"
    assert group.probability > FIRM
    assert group.members[0][1] > FIRM
    assert found.doubted == ()
    assert not found.unexplained


def test_the_order_of_a_law_is_chosen_anew_next_to_another_effect() -> None:
    """Next to plain springs order 4 read best; no fit changes it, and what it left was called unexplained."""
    found = said_of(CAMPAIGNS / "joints/04")
    assert {group.members[0][0] for group in found.groups if group.firm} == {
        "cubic-stiffness j1",
        "periodic-stiffness j1",
    }
    assert not found.unexplained


def test_most_runs_have_to_agree() -> None:
    """A spring that stiffens with the rate: three of six runs were off, and then all."""
    found = said_of(CAMPAIGNS / "joints/05")
    assert len(found.doubted) <= 1
    assert not any(group.firm for group in found.groups)
    assert found.unexplained


def test_a_law_outside_the_catalogue_is_none_of_its_effects() -> None:
    found = said_of(CAMPAIGNS / "absolute/07")
    assert found.groups == ()
    assert found.unexplained
