"""What limits the answer of a search is stated."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from stiffcal.diagnosis import search as module
from stiffcal.diagnosis.search_warnings import search_warnings
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.model.no_balance import NoBalanceError
from tests.diagnosis.test_same_within_noise import places_with


def test_effects_that_cannot_be_judged_for_want_of_an_equilibrium_are_stated(monkeypatch: pytest.MonkeyPatch) -> None:
    def falling(*_: Any) -> Any:
        raise NoBalanceError("the robot falls")

    states, robot = places_with([], seed=1)
    catalogue = {"joint-eccentricity": JointEccentricity()}
    monkeypatch.setattr(module, "_judged", falling)
    search = module.search_missing(states, robot, catalogue)
    assert (search.tried, search.without_balance) == ((), True)
    (warning,) = set(search_warnings(search)) - set(search_warnings(replace(search, without_balance=False)))
    assert "has no equilibrium" in warning
