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
