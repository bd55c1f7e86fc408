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
SENTENCE = (
    "  geometry known to 0.41 mm per length and 0.016° per angle, see /a/folder/that/is/long/robot.toml for details"
)


def printed(width: int, terminal: bool = True) -> str:
    """Return a table and a sentence as a console of `width` columns draws them."""
    stream = StringIO()
    console = AnswerConsole(
        file=stream, width=width, force_terminal=terminal, color_system=None, highlight=False, markup=False
    )
    table = plain_table("effect", "place", "verdict", "held-out, rms>", "explains>", "first in>", "at the tool>")
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
    assert all(len(line.rstrip()) <= width for line in text.splitlines())


def test_columns_stack_where_their_words_do_not_fit() -> None:
    lines = printed(60).splitlines()
    assert "friction-hysteresis joint 2 and joint 3 rejected" in lines
    assert "  held-out, rms: 0.133 mm, 0.0713 mrad   explains: 12.0 %" in lines


def test_a_sentence_in_a_pipe_is_one_line() -> None:
    assert SENTENCE in printed(80, terminal=False).splitlines()
