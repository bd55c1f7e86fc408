"""`improve` adds a limited number of effects at all joints in one run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.model.summary import EffectAt, Where
from stiffcal.workflow import improve

LAWS = ("joint-eccentricity", "periodic-stiffness", "cubic-stiffness", "two-slope")


@dataclass
class _Diagnosed:
    """Of a campaign in which every law at all joints lowers the error, one after another."""

    everywhere: EffectAt | None
    warnings: list[str] = field(default_factory=list)
    missing: list[Any] = field(default_factory=list)
    superfluous: list[Any] = field(default_factory=list)
    undecided: list[Any] = field(default_factory=list)
    unexplained: bool = True


@pytest.mark.parametrize("n_laws", [1, 2, 4])
def test_what_is_left_after_the_limit_is_named(monkeypatch: pytest.MonkeyPatch, n_laws: int) -> None:
    steps: list[EffectAt] = []
    recorder: Any = SimpleNamespace(
        steps=steps, folder=Path(), context=None, edit=lambda change, effect: steps.append(effect)
    )

    def diagnose(*_: object) -> _Diagnosed:
        left = LAWS[len(steps) : n_laws]
        return _Diagnosed(EffectAt(effect=left[0], where=Where(joints=[1, 2, 3])) if left else None)

    monkeypatch.setattr(improve, "diagnose_campaign", diagnose)
    first: Any = diagnose()
    results: list[Any] = []

    def all_steps() -> Iterator[object]:
        results.append((yield from improve._add_and_remove(recorder, first, improve.always)))

    assert len(list(all_steps())) == 2 * len(steps)  # each of them, and the diagnosis after it
    (result,) = results
    assert [step.effect for step in steps] == list(LAWS[: min(n_laws, 2)])
    assert [LAWS[2] in text for text in result.warnings] == [True] * (n_laws > 2)
