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
    words, (table, _, hidden) = text.split(), text.partition("not shown")
    for title, *cells in zip(TITLES, *ROWS, strict=True):
        for cell in cells:
            assert title.split()[0] in hidden or set(cell.split()) <= set(words)
            assert title in hidden or not cell.endswith("%") or any(cell in line for line in table.splitlines())
    assert set(SENTENCE.split()) <= set(words)
    assert all(len(line.rstrip()) <= width for line in text.splitlines())


def test_what_does_not_fit_next_to_the_columns_before_it_goes_and_is_named() -> None:
    lines = printed(80).splitlines()
    assert lines[0].split("   ")[0] == "effect"
    assert [title for title in TITLES if title not in lines[0]] == ["held-out, rms"]
    assert "  not shown on 80 columns: held-out, rms" in lines
    assert "not shown" not in printed(120)


def test_a_sentence_in_a_pipe_is_one_line() -> None:
    assert SENTENCE in printed(80, terminal=False).splitlines()
