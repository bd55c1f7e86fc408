"""How a rival that was refitted compares with the set about whose fit all are weighed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.judgement import rivals
from stiffcal.judgement.evidence import Key
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.sets import WeighedSets

OWN, RIVAL = (0, 1), (0,)


def difference(monkeypatch: pytest.MonkeyPatch, rival_there: float, own_there: float) -> float:
    """Return by how much the rival leads after its refit; before it is 1.5 behind.

    Parameters
    ----------
    rival_there, own_there : log weights of the rival and of the set about the rival's fit.
    """
    members: Any = [SimpleNamespace(name=name, kind=MemberKind.EFFECT, candidate=None, setting=None) for name in "ab"]
    weighed = WeighedSets(members, Any, {OWN: -100.0, RIVAL: -101.5}, {OWN: -100.0, RIVAL: -101.5})  # type: ignore[arg-type, dict-item]

    def about_fit(_: WeighedSets, key: Key, fitted: Key, *others: object) -> float:
        assert fitted == RIVAL
        return rival_there if key == RIVAL else own_there

    monkeypatch.setattr(rivals, "_about_fit", about_fit)
    monkeypatch.setattr(rivals, "bent_without", lambda weighed, own: [])
    ground: Any = None
    found = rivals.with_rivals_refitted(weighed, OWN, ground, lambda members: ground)
    return found.log[RIVAL] - found.log[OWN]


def test_what_is_bent_is_gained(monkeypatch: pytest.MonkeyPatch) -> None:
    """About the rival's fit the set without a straight line is 20 better than the one with it."""
    assert difference(monkeypatch, -90.0, -110.0) == pytest.approx(10.0)


def test_levels_of_two_fits_do_not_compare(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fixture's compliance of nothing was certain: it is worth 1.5 about either fit, and all is 6 less about one."""
    assert difference(monkeypatch, -107.6, -106.0) == pytest.approx(-1.6)
    assert difference(monkeypatch, -92.0, -90.5) == pytest.approx(-1.5)
