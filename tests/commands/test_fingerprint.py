"""Numbers do not change unnoticed: some answers on bundled campaigns are those of this revision."""

from __future__ import annotations

import json

import pytest

from stiffcal.revision import REVISION
from tests.fingerprint import FILE, differences, fingerprint, rounded

CHANGED = "numbers changed: raise REVISION and rewrite the fingerprint with `make fingerprint`"


def test_the_answers_are_those_of_this_revision() -> None:
    then = json.loads(FILE.read_text("utf-8"))
    assert then["revision"] == REVISION, "rewrite the fingerprint with `make fingerprint`"
    found = list(differences(then, rounded(fingerprint())))
    assert not found, "\n".join([CHANGED, *found[:20]])


def test_the_fingerprint_is_small() -> None:
    assert FILE.stat().st_size <= 50_000


@pytest.mark.parametrize(
    ("then", "now", "places"),
    [
        ({"rms": {"translation": 1e-4}}, {"rms": {"translation": 1.0000005e-4}}, []),
        ({"rms": {"translation": 1e-4}}, {"rms": {"translation": 1.00001e-4}}, ["rms.translation"]),
        ({"value": 1e-6, "std": 1e-3}, {"value": 1.05e-6, "std": 1e-3}, []),
        ({"value": 1e-6, "std": 1e-9}, {"value": 1.001e-6, "std": 1e-9}, ["value"]),
        ({"missing": ["a"]}, {"missing": ["b"]}, ["missing[0]"]),
        ({"missing": ["a"]}, {"missing": []}, ["missing"]),
        ({"noise": None}, {"noise": 0.0}, ["noise"]),
        ({"adequate": True}, {"adequate": False}, ["adequate"]),
    ],
)
def test_a_change_beyond_arithmetic_is_named(then: object, now: object, places: list[str]) -> None:
    assert [line.split(":")[0] for line in differences(then, now)] == places
