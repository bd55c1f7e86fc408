"""Answers on a narrow terminal: no word and no number is split, in sentences or in tables."""

from __future__ import annotations

from io import StringIO

import pytest

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.tables import plain_table

ROWS = [
    ("friction-hysteresis", "joint 2 and joint 3", "rejected", "0.133 mm, 0.0713 mrad", "12.0 %", "98.0 %", "0.012 mm"),
    ("thermal-drift", "", "supported", "0.0439 mm, 0.0474 mrad, 0.0012 mm at the rods", "100 %", "–", "0.120 mm"),
]
LONGEST = len("friction-hysteresis   0.0439 mm, 0.0474 mrad, 0.0012 mm at the rods")
"""Columns of the narrowest part."""
TITLES = ("effect", "place", "verdict", "held-out, rms", "explains", "first in", "at the tool")
SENTENCE = (
    "  geometry known to 0.41 mm per length and 0.016° per angle, see /a/folder/that/is/long/robot.toml for details"
)


def printed(width: int, terminal: bool = True) -> str:
    """Return a table and a sentence as a console of `width` columns draws them."""
    stream = StringIO()
    console = AnswerConsole(
        file=stream, width=width, force_terminal=terminal, color_system=None, highlight=False, markup=False
    )
    table = plain_table(*TITLES[:3], *(f"{title}>" for title in TITLES[3:]))
    for row in ROWS:
        table.add_row(*row)
    console.print(table)
    console.print(SENTENCE, soft_wrap=True)
    return stream.getvalue()


@pytest.mark.parametrize("width", [40, 60, 80, 100, 120, 200])
def test_no_word_and_no_number_is_split(width: int) -> None:
    text = printed(width)
    words = text.split()
    for row in ROWS:
        for cell in row:
            assert set(cell.split()) <= set(words)
        for number in (row[4], row[6]):
            assert any(number in line for line in text.splitlines())
    assert set(SENTENCE.split()) <= set(words)
    assert all(len(line.rstrip()) <= max(width, LONGEST) for line in text.splitlines())


def test_columns_without_room_stand_below_with_the_first_column_again() -> None:
    lines = printed(80).splitlines()
    headers = [line for line in lines if line.startswith("effect")]
    assert [[title for title in TITLES if title in line] for line in headers] == [
        ["effect", "place", "verdict"], ["effect", "held-out, rms", "explains"], ["effect", "first in", "at the tool"],
    ]  # fmt: skip
    assert sum(line.startswith("thermal-drift") for line in lines) == len(headers)
    assert sum(line.startswith("effect") for line in printed(200).splitlines()) == 1


def test_a_unit_stays_with_its_number() -> None:
    table = plain_table("effect", "stiffness, ± 95 %>", "", "share of geometry>")
    table.add_row("joint-compliance", "(7.335 ± 0.067)·10⁵", "N·m/rad", "14 %")
    stream = StringIO()
    AnswerConsole(file=stream, width=50, force_terminal=True, color_system=None).print(table)
    lines = stream.getvalue().splitlines()
    assert [("±" in line, "N·m/rad" in line) for line in lines if line.startswith("joint")] == [
        (True, True), (False, False)
    ]  # fmt: skip


def test_a_sentence_in_a_pipe_is_one_line() -> None:
    assert SENTENCE in printed(80, terminal=False).splitlines()


def test_a_secondary_column_goes_before_a_cell_wraps_and_a_unit_stays_with_its_number() -> None:
    stream = StringIO()
    console = AnswerConsole(
        file=stream, width=50, force_terminal=True, color_system=None, highlight=False, markup=False
    )
    table = plain_table("effect", "stiffness>", "share>", "", secondary=[2])
    table.add_row("joint-compliance", "2.70·10⁶", "56 %", "N·m/rad  shifted")
    console.print(table)
    assert [line.split() for line in stream.getvalue().splitlines()[-2:]] == [
        ["joint-compliance", "2.70·10⁶", "N·m/rad", "shifted"],
        ["no", "room", "for:", "share"],
    ]
