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
