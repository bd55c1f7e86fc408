"""Numbers that decide in the reduction of logs have a reason, and the table holds them as they are."""

from __future__ import annotations

import re
from pathlib import Path

from stiffcal.ingest.quality import data_quality
from stiffcal.mistakes.references import match
from tests.limits.__main__ import varied_in
from tests.limits.kept import Kept
from tests.limits.numbers import ROOMS, Number, files_of, numbers, unnamed
from tests.limits.page import PAGE, Moved, shown, written
from tests.limits.varying import varied


def test_every_number_says_what_it_rests_on() -> None:
    assert [number.place for number in numbers() if not number.reason] == []


def test_no_number_decides_in_holds_and_clocks_without_a_name() -> None:
    found: list[str] = []
    for file in files_of("reduction/holds", "reduction/clocks", *(room for room in ROOMS if room.endswith(".py"))):
        found += unnamed(file.read_text(encoding="utf-8"))
    assert found == []


def test_a_literal_inside_a_function_is_found() -> None:
    text = """
SHARE = 0.3

def held(x):
    a = 0.25 * x[:2] + max(1e-300, 2.0 * x) + significant(x, 4) + 0.5 * SHARE
    return a if len(x) > 7 else None
"""
    assert unnamed(text) == ["0.25 in held, line 5", "7 in held, line 6"]


def test_every_number_is_in_the_table_with_its_present_value() -> None:
    page = PAGE.read_text(encoding="utf-8")
    wanted = [(re.escape(f"`{one.place}`"), re.escape(shown(one.value))) for one in numbers()]
    missing = [
        name for name, value in wanted if not re.search(rf"(\| {name} \| {value} \||- {name} {value}[\n:])", page)
    ]
    assert missing == []


def test_a_number_is_varied_wherever_it_was_imported_to() -> None:
    (number,) = (one for one in numbers() if one.place == "mistakes/references/match.MEETS_M")
    places = (vars(match), vars(data_quality))
    with varied(number, 1.2):
        assert [place["MEETS_M"] for place in places] == [1.2 * number.value] * 2
    assert [place["MEETS_M"] for place in places] == [number.value] * 2


def test_a_further_log_varies_what_none_before_it_asks_for() -> None:
    asked = {"demo": frozenset("ab"), "hidden/02": frozenset("b"), "kr240": frozenset("bc"), "irb4400": frozenset("cd")}
    varied_with = varied_in(asked, frozenset("abc"))
    assert varied_with == dict(zip(asked, (frozenset("ab"), {"b"}, {"c"}, frozenset()), strict=True))


def test_what_moves_most_is_in_the_table_and_what_moves_nothing_is_listed() -> None:
    large, still, idle = (Number("stiffcal.reduction.x", name, 3, "a reason") for name in "ABC")
    moves = {large.place: (Moved(), Moved(states=-4, sigma=0.5)), still.place: (Moved(), Moved())}
    less = {large.place: (Moved(refused=True), Moved(sigma=0.1))}
    lines = written([large, still, idle], {"one": moves, "two": less}).splitlines()
    assert "| `reduction/x.A` | 3 | refused | -4 states, 0.5 σ | two | a reason |" in lines
    assert (
        lines.index("- `reduction/x.B` 3")
        < lines.index("## Not asked for by these logs")
        < lines.index("- `reduction/x.C` 3: a reason")
    )


def test_a_call_that_was_ended_goes_on_where_it_was_and_anew_with_other_code(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    kept = Kept.of_this_code(file)
    kept.keep_asked("demo 1f", frozenset("a"), frozenset("b"), 1.0)
    kept.keep_moved("demo 1f", "a", (Moved(refused=True), Moved(sigma=0.1)), 2.5)
    with file.open("a", encoding="utf-8") as lines:
        lines.write('{"log": "demo 1f", "place": "b", "le')
    again = Kept.of_this_code(file)
    again.keep_moved("demo 1f", "b", (Moved(), Moved()), 0.0)
    assert again.asked("demo 1f") == (frozenset("a"), frozenset("b"))
    assert again.asked("demo 2e") is None
    assert again.moved("demo 1f") == {"a": (Moved(refused=True), Moved(sigma=0.1)), "b": (Moved(), Moved())}
    assert again.seconds() == 3.5
    file.write_text(file.read_text(encoding="utf-8").replace("code", "other"), encoding="utf-8")
    assert Kept.of_this_code(file).asked("demo 1f") is None
