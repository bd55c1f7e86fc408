"""Absolute places and clamped joints, judged by what judges load states: bundled campaigns of another simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

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
    ],
)
def test_what_is_hidden_is_named_and_firm(name: str, effect: str) -> None:
    (group,) = said_of(CAMPAIGNS / name).groups
    assert group.members[0][0] == effect
    assert group.firm


def test_a_law_outside_the_catalogue_is_none_of_its_effects() -> None:
    found = said_of(CAMPAIGNS / "absolute/07")
    assert found.groups == ()
    assert found.unexplained
