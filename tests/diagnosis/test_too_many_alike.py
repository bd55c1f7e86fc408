"""Of more look-alikes than can be listed, those with the most evidence are: the named one has no place of its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from stiffcal.diagnosis import deletions
from stiffcal.diagnosis.scan import Scan, Trial

SHARES = {"a": 0.02, "b": 0.4, "c": 0.3, "d": 0.2, "e": 0.08, "f": 0.0}


def trial_of(name: str) -> Trial:
    return cast("Trial", SimpleNamespace(candidate=SimpleNamespace(name=name, effect=SimpleNamespace(general=False))))


def rivals(monkeypatch: pytest.MonkeyPatch, names: str) -> list[str]:
    monkeypatch.setattr(deletions, "confidence", lambda scan, among: SHARES)
    near = [trial_of(name) for name in names]
    return [rival.candidate.name for rival in deletions.too_many_alike(cast("Scan", None), near, near[0])]


def test_the_four_with_the_most_evidence_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert rivals(monkeypatch, "abcdef") == ["b", "c", "d", "e"]


def test_as_many_as_can_be_listed_are_no_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    assert rivals(monkeypatch, "abcde") == []
