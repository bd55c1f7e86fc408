"""Times in words: the order of day and month is looked for once, whatever it is."""

from __future__ import annotations

import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements import timestamps
from stiffcal.measurements.timestamps import seconds_of_times


@pytest.mark.parametrize("form", ["20.11.2026 10:15:{:02d},5", "11/20/2026 10:15:{:02d}.5", "10:15:{:02d}.5"])
def test_all_dates_are_looked_through_once_at_most(form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    look = timestamps._order_in

    def counted(texts: list[str], *place: str) -> str:
        seen.append(len(texts))
        return look(texts, *place)

    monkeypatch.setattr(timestamps, "_order_in", counted)
    seconds = seconds_of_times([form.format(k % 60) for k in range(300)], "log.csv", "t", 1)
    assert seconds[59] - seconds[0] == 59.0
    assert len(seen) <= 1


def test_a_date_whose_order_is_open_is_found_below_dates_whose_order_is_not() -> None:
    with pytest.raises(InputError) as caught:
        seconds_of_times(["20.11.2026 10:00:00", "05/11/2026 10:00:01"], "log.csv", "t", 1)
    assert caught.value.code is FaultCode.TIME_AMBIGUOUS
    assert "row 2" in caught.value.place


@pytest.mark.parametrize(
    "text",
    [
        "2026-11-20 오후 1:15:30.5", "2026. 11. 20. 오후 1:15:30.5", "2026년 11월 20일 오후 1:15:30,5",
        "2026/11/20 下午 1:15:30.5", "2026/11/20 午後1:15:30.5", "2026年11月20日 午後 1:15:30.5",
    ],
)  # fmt: skip
def test_halves_of_the_day_before_the_clock(text: str) -> None:
    after_noon, expected = seconds_of_times([text, "2026-11-20T13:15:30.5Z"], "log.csv", "t", 1)
    assert after_noon == expected
    midnight = text.replace("오후", "오전").replace("下午", "上午").replace("午後", "午前").replace("1:15", "12:15")
    assert seconds_of_times([midnight], "log.csv", "t", 1)[0] == expected - 13 * 3600


@pytest.mark.parametrize(
    "text",
    [
        "Fri 20 Nov 2026 10:15:30.5", "ven. 20 nov. 2026 10:15:30,5", "Fr 20.11.2026 10:15:30,5",
        "Freitag, 20. November 2026 10:15:30,5", "20 de noviembre de 2026 10:15:30,5", "Fri 2026-11-20 10:15:30.5",
        "2026年11月20日 星期五 10时15分30.5秒", "2026年11月20日(金) 10時15分30.5秒",
        "2026년 11월 20일 금요일 10시 15분 30.5초", "Fri, 20 Nov 2026 11:15:30.5 +0100", "20.11.2026 10:15:30,5 UTC",
        "20/11/2026 04:45:30.5-05:30",
    ],
)  # fmt: skip
def test_days_of_the_week_and_clocks_in_signs(text: str) -> None:
    one, expected = seconds_of_times([text, "2026-11-20T10:15:30.5Z"], "log.csv", "t", 1)
    assert one == expected


@pytest.mark.parametrize(
    ("month", "number"),
    [("juin", 6), ("juillet", 7), ("juil.", 7), ("Mar", 3), ("outubro", 10), ("mrt", 3), ("giugno", 6), ("Dic.", 12)],
)
def test_months_of_one_beginning_are_distinguished(month: str, number: int) -> None:
    one, expected = seconds_of_times([f"20 {month} 2026 10:00:00", f"2026-{number:02d}-20 10:00:00"], "l.csv", "t", 1)
    assert one == expected


@pytest.mark.parametrize("text", ["Mar 20, 2026 10:00:00", "Dic 20, 2026 10:00:00"])
def test_a_month_that_begins_like_a_day_of_the_week(text: str) -> None:
    expected = "2026-03-20" if text[0] == "M" else "2026-12-20"
    one, other = seconds_of_times([text, f"{expected} 10:00:00"], "l.csv", "t", 1)
    assert one == other
