"""How a rival that was refitted compares with the set about whose fit all are weighed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.judgement import rivals
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.sets import WeighedSets

OWN, RIVAL = (0, 1), (0,)


def difference(monkeypatch: pytest.MonkeyPatch, rival_there: float, weights: float = 0.0) -> float:
    """Return by how much the rival leads after its refit; before it is 1.5 behind.

    Parameters
    ----------
    rival_there : log weight of the rival about its own fit. weights : by how much its weights are larger there.
    """
    members: Any = [SimpleNamespace(name=name, kind=MemberKind.EFFECT, candidate=None, setting=None) for name in "ab"]
    weighed = WeighedSets(members, Any, {OWN: -100.0, RIVAL: -101.5}, {OWN: -100.0, RIVAL: -101.5})  # type: ignore[arg-type, dict-item]
    monkeypatch.setattr(rivals, "_about_own_fit", lambda *others: rival_there)
    monkeypatch.setattr(rivals, "bent_without", lambda weighed, own: [])
    about: Any
    there: Any
    about, there = (SimpleNamespace(log_weights=value) for value in (20.0, 20.0 + weights))
    scale: Any = None
    found = rivals.with_rivals_refitted(weighed, OWN, about, scale, lambda members: there)
    return found.log[RIVAL] - found.log[OWN]


def test_what_is_bent_is_gained(monkeypatch: pytest.MonkeyPatch) -> None:
    assert difference(monkeypatch, -90.0) == pytest.approx(10.0)


def test_a_steeper_law_makes_readings_less_dense(monkeypatch: pytest.MonkeyPatch) -> None:
    """The noise of the force is carried into them: with less weight their squares are smaller, so is their density."""
    assert difference(monkeypatch, -90.0, -12.0) == pytest.approx(-2.0)
