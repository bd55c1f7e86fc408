"""What is read off probabilities of sets."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.judgement.evidence import Key
from stiffcal.judgement.numbers import DISCREPANCIES, SCATTERS, SHOWS
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


@pytest.mark.parametrize("absolute", [False, True])
def test_a_discrepancy_shows_by_its_rms_over_all_readings(absolute: bool) -> None:
    """Half of the noise and more, or as much as an effect; the scatter of absolute places from the noise on."""
    size = SCATTERS if absolute else SHOWS
    of_loads, of_time = (SimpleNamespace(variance=np.full(50, 0.5)) for _ in range(2))
    where = {id(of_loads): 1, id(of_time): 1 + len(DISCREPANCIES)}
    shared = SimpleNamespace(numbers_of=lambda one: [where[id(one)] + k for k in range(len(DISCREPANCIES))])
    space = SimpleNamespace(data=SimpleNamespace(absolute=np.full(9, absolute)))
    ground = SimpleNamespace(of_loads=of_loads, of_time=of_time, shared=shared, space=space)
    noise = SimpleNamespace(noise=SimpleNamespace(dof=100.0))

    def left(one: SimpleNamespace, number: int, least: float) -> float:
        of_discrepancy = np.eye(1 + 2 * len(DISCREPANCIES))[where[id(one)] + number]
        weighed = SimpleNamespace(of_discrepancy=lambda: of_discrepancy, evidence=noise)
        judged: Any = SimpleNamespace(ground=ground, weighed=weighed)
        return _left(judged, least)

    for one, least in ((of_loads, size), (of_time, SHOWS)):
        # of a hundred readings fifty directions are moved, by half the variance of the discrepancy
        first = int(np.argmax(least <= DISCREPANCIES / 2.0))
        assert [left(one, k, 0.0) for k in (first - 1, first)] == [0.0, 1.0]
        assert left(one, first, DISCREPANCIES[first]) == 1.0
        assert left(one, first, 1.01 * DISCREPANCIES[first]) == 0.0


def test_the_present_model_has_the_shapes_that_were_weighed() -> None:
    """Of shapes that a fit makes alike one stands for all, and the others are in no set; that ended with exit 3."""
    members = [SimpleNamespace(name=name) for name in ("backlash j2", "backlash j2", "backlash j2", "bearing-tilt j2")]
    names: dict[Key, frozenset[str]] = {(k,): frozenset({members[k].name}) for k in (1, 2, 3)}
    log = {(1,): -3.0, (2,): -2.0, (3,): -5.0}
    model = frozenset({"backlash j2", "bearing-tilt j2"})
    judged: Any = SimpleNamespace(members=members, model=model, weighed=SimpleNamespace(log=log))
    assert _present(judged, names) == (2, 3)
