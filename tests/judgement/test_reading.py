"""What is read off probabilities of sets."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.judgement.evidence import Key
from stiffcal.judgement.numbers import SHOWS
from stiffcal.judgement.reading import _left, _present, _shares


def test_a_group_without_any_set_has_no_shares() -> None:
    """Without the discrepancy the sets with an effect may have no probability at all; that ended with exit 3."""
    names: dict[Key, frozenset[str]] = {(0,): frozenset({"creep j1"}), (1,): frozenset({"backlash j1"})}
    assert _shares({"creep j1"}, {(0,): 0.0, (1,): 1.0}, names) == {}
    assert _shares({"creep j1"}, {(0,): 0.2, (1,): 0.8}, names) == {"creep j1": 1.0}


def test_an_effect_has_one_probability_in_its_group_and_by_itself() -> None:
    """By the rule for conditional probabilities: one in all sets was named with 95 % next to one in few."""
    sets: dict[Key, float] = {(0,): 0.5, (0, 1): 0.1, (1, 2): 0.2, (2,): 0.2}
    names: dict[Key, frozenset[str]] = {key: frozenset("abc"[i] for i in key) for key in sets}
    shares = _shares({"a", "b"}, sets, names)
    assert shares == {"a": pytest.approx(0.6 / 0.8), "b": pytest.approx(0.3 / 0.8)}
    assert _shares({"a", "b"}, {(0,): 0.9, (0, 1): 0.1}, names)["a"] == 1.0


def test_what_may_be_there_besides_is_nothing_in_its_place() -> None:
    """Two of three sweeps of a bench were not certain of a play, as a drift next to it had one set in ten."""
    names: dict[Key, frozenset[str]] = {
        (0,): frozenset({"backlash j1"}),
        (0, 1): frozenset({"backlash j1", "encoder-drift j1"}),
        (1,): frozenset({"encoder-drift j1"}),
    }
    own = {"backlash j1", "encoder-drift j1"}
    shares = _shares(own, {(0,): 0.86, (0, 1): 0.1, (1,): 0.04}, names)
    assert shares == pytest.approx({"backlash j1": 0.96, "encoder-drift j1": 0.14})


@pytest.mark.parametrize("drifts", [False, True])
def test_what_dies_away_within_some_readings_is_noise_unless_it_is_larger(drifts: bool) -> None:
    """A compliance that waves as the load cycles left a curve of half its size certain, and nothing unexplained."""
    of_loads, of_time = object(), object()
    numbers = {id(of_loads): [1, 2, 3, 4, 5, 6], id(of_time): [7, 8, 9, 10, 11, 12]}
    shared = SimpleNamespace(numbers_of=lambda one: numbers[id(one)])

    def left(number: int, size: float) -> float:
        ground = SimpleNamespace(of_loads=of_loads, of_time=of_time, shared=shared)
        weighed = SimpleNamespace(of_discrepancy=lambda: np.eye(13)[number])
        judged: Any = SimpleNamespace(ground=ground, weighed=weighed, drift=SimpleNamespace(drifts=drifts))
        return _left(judged, size)

    assert left(12, 1.06) == left(12, SHOWS) == 1.0
    assert left(12, 10.0) == 0.0
    assert left(10, 1.06) == left(10, SHOWS) == drifts
    assert left(4, 1.06) == 1.0


def test_the_present_model_has_the_shapes_that_were_weighed() -> None:
    """Of shapes that a fit makes alike one stands for all, and the others are in no set; that ended with exit 3."""
    members = [SimpleNamespace(name=name) for name in ("backlash j2", "backlash j2", "backlash j2", "bearing-tilt j2")]
    names: dict[Key, frozenset[str]] = {(k,): frozenset({members[k].name}) for k in (1, 2, 3)}
    log = {(1,): -3.0, (2,): -2.0, (3,): -5.0}
    model = frozenset({"backlash j2", "bearing-tilt j2"})
    judged: Any = SimpleNamespace(members=members, model=model, weighed=SimpleNamespace(log=log))
    assert _present(judged, names) == (2, 3)
