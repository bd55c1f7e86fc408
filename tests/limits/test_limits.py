"""Numbers that decide in the reduction of logs have a reason, and the table holds them as they are."""

from __future__ import annotations

from stiffcal.ingest.quality import data_quality
from stiffcal.mistakes.references import match
from tests.limits.numbers import Number, numbers
from tests.limits.page import PAGE, Moved, shown, written
from tests.limits.varying import varied


def test_every_number_says_what_it_rests_on() -> None:
    assert [number.place for number in numbers() if not number.reason] == []


def test_every_number_is_in_the_table_with_its_present_value() -> None:
    page = PAGE.read_text(encoding="utf-8")
    wanted = [(f"`{one.place}`", shown(one.value)) for one in numbers()]
    missing = [
        name for name, value in wanted if f"| {name} | {value} |" not in page and f"- {name} {value}\n" not in page
    ]
    assert missing == []


def test_a_number_is_varied_wherever_it_was_imported_to() -> None:
    (number,) = (one for one in numbers() if one.place == "mistakes/references/match.MEETS_M")
    places = (vars(match), vars(data_quality))
    with varied(number, 1.2):
        assert [place["MEETS_M"] for place in places] == [1.2 * number.value] * 2
    assert [place["MEETS_M"] for place in places] == [number.value] * 2


def test_what_moves_most_is_in_the_table_and_what_moves_nothing_is_listed() -> None:
    large, still, idle = (Number("stiffcal.reduction.x", name, 3, "a reason") for name in "ABC")
    moves = {large.place: (Moved(), Moved(states=-4, sigma=0.5)), still.place: (Moved(), Moved()), idle.place: None}
    less = {large.place: (Moved(refused=True), Moved(sigma=0.1)), still.place: None, idle.place: None}
    lines = written([large, still, idle], {"one": moves, "two": less}).splitlines()
    assert "| `reduction/x.A` | 3 | refused | -4 states, 0.5 σ | two | a reason |" in lines
    assert (
        lines.index("- `reduction/x.B` 3")
        < lines.index("## Not asked for by these logs")
        < lines.index("- `reduction/x.C` 3")
    )
