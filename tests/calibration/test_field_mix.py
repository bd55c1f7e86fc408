"""The field mix is what it is said to be, and an answer on it is good when the table says so."""

from __future__ import annotations

import numpy as np
import pytest

from tests.calibration.answers import Answer, Named, firm_wrong, is_good
from tests.calibration.field_mix import FieldCampaign, draw_campaign
from tests.calibration.judging import JudgedCampaign, read_line

NAN = float("nan")
SEED = 9001


def answer(*named: Named, unexplained: bool = False, doubted: tuple[int, ...] = ()) -> Answer:
    return Answer(named, unexplained, doubted, NAN, NAN, 0.0)


def named(*names: str, firm: bool = True) -> Named:
    return Named(names, NAN, (), firm)


@pytest.fixture(scope="module")
def campaigns() -> dict[str, FieldCampaign]:
    """Return a campaign of each category that the tests below ask for."""
    return {"nothing": draw_campaign(SEED, 1), "one": draw_campaign(SEED, 0), "mistake": draw_campaign(SEED, 21)}


def test_a_campaign_follows_from_its_number() -> None:
    one, again = draw_campaign(SEED, 1), draw_campaign(SEED, 1)
    np.testing.assert_array_equal(one.states.position, again.states.position)


def test_nothing_is_good_where_nothing_is_said(campaigns: dict[str, FieldCampaign]) -> None:
    nothing = campaigns["nothing"]
    assert is_good(nothing, answer())
    assert not is_good(nothing, answer(named("creep j1", firm=False)))
    assert not is_good(nothing, answer(unexplained=True))
    assert not is_good(nothing, answer(doubted=(3,)))
    assert firm_wrong(nothing, answer(named("creep j1"))) == 1
    assert firm_wrong(nothing, answer(named("creep j1", firm=False))) == 0


def test_one_is_good_where_its_group_is_first(campaigns: dict[str, FieldCampaign]) -> None:
    one = campaigns["one"]
    right = "target-offset setup"
    assert [h.effect.name for h in one.hidden] == ["target-offset"]
    assert is_good(one, answer(named(right)))
    assert is_good(one, answer(named("tool-compliance setup", right)))
    assert not is_good(one, answer(named("creep j1"), named(right)))
    assert not is_good(one, answer())
    assert firm_wrong(one, answer(named("tool-compliance setup", right))) == 0
    assert firm_wrong(one, answer(named("creep j1"), named(right))) == 1


def test_a_mistake_is_good_where_its_runs_are_named(campaigns: dict[str, FieldCampaign]) -> None:
    mistake = campaigns["mistake"]
    first = mistake.runs[0]
    assert is_good(mistake, answer(doubted=mistake.runs))
    assert is_good(mistake, answer(doubted=(first,)))
    assert not is_good(mistake, answer(doubted=(first, max(mistake.runs) + 1)))
    assert not is_good(mistake, answer())


def test_a_judged_campaign_is_read_as_it_was_written() -> None:
    """An answer without probabilities holds NaN, which is not equal to itself: lines are compared."""
    one = JudgedCampaign(
        3, "one", "repeats", "balance", "heavy", 12, (1.5,), ("creep j1",), ("creep j1",), (),
        answer(named("creep j1")), "1 right", True, 0,
    )  # fmt: skip
    again = read_line(one.line())
    assert again.line() == one.line()
    assert again.answer.named[0].names == ("creep j1",)
