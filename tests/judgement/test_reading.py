"""What is read off probabilities of sets."""

from __future__ import annotations

from stiffcal.judgement.reading import _within
from stiffcal.judgement.sets import Key


def test_a_group_without_any_set_has_no_shares() -> None:
    """Without the discrepancy the sets with an effect may have no probability at all; that ended with exit 3."""
    names: dict[Key, frozenset[str]] = {(0,): frozenset({"creep j1"}), (1,): frozenset({"backlash j1"})}
    assert _within({"creep j1"}, frozenset(), {(0,): 0.0, (1,): 1.0}, names) == {}
    assert _within({"creep j1"}, frozenset(), {(0,): 0.2, (1,): 0.8}, names) == {"creep j1": 1.0}
