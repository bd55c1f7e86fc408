"""The field mix is what it is said to be, and an answer on it is good when the table says so."""

from __future__ import annotations

import numpy as np
import pytest

from tests.calibration.answers import Answer, Named, firm_wrong, is_good
from tests.calibration.field_mix import FieldCampaign, draw_campaign
from tests.calibration.judging import JudgedCampaign, read_line
from tests.calibration.tables import recalibrated, table

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


def test_a_group_is_right_where_any_of_it_is_there() -> None:
    """Of the whole group the probability is, not of the names that reach 95 % of it; a mistake is there by its run."""
    group = Named(("backlash j4",), 0.99, (0.97,), False, ("two-slope j4", "seat-shift setup"), (3,))
    assert group.holds(("two-slope j4",), ())
    assert group.holds((), (3, 8))
    assert not group.holds(("creep j4",), (8,))


def test_probabilities_that_are_true_have_the_slope_one_and_sure_ones_a_smaller() -> None:
    stated = np.array([0.6, 0.8, 0.9, 0.98])
    true = [(p, k < round(1000 * p)) for p in stated for k in range(1000)]
    sure = [(p, k < round(1000 * p**0.5 / (p**0.5 + (1.0 - p) ** 0.5))) for p in stated for k in range(1000)]
    assert recalibrated(true)[0] == pytest.approx(1.0, abs=0.01)
    assert recalibrated(sure)[0] == pytest.approx(0.5, abs=0.01)
    assert recalibrated(true)[1] > recalibrated(true)[2]
    assert recalibrated(sure)[1] < recalibrated(sure)[2]


def test_effects_that_an_oracle_finds_are_counted_by_their_names() -> None:
    def judged(size: float, *given: Named) -> JudgedCampaign:
        return JudgedCampaign(
            3, "one", "repeats", "balance", "", 100, (size,), ("creep j1",), ("creep j1",), (), answer(*given), "",
            True, 0,
        )  # fmt: skip

    alike = Named(("backlash j1", "creep j1"), 0.99, (0.6, 0.35), firm=False)
    sure = Named(("creep j1",), 0.99, (1.0,), firm=True)
    text = table([judged(0.3), judged(1.0, sure), judged(1.0, alike), judged(1.0), judged(5.0, alike)])
    assert "among the names: 3 of 4; names: 2 in the median, 1.67 in the mean" in text
    assert "firm and right 1 of 2" in text
