"""What is printed as TOML can be pasted: it parses, and names in it are quoted as TOML wants them."""

from __future__ import annotations

import re
import tomllib

import pytest

from docs.page_blocks import hand_written_pages, page_text
from stiffcal.campaign.signals.row_filter import RowCondition, condition_text, parse_rows
from stiffcal.diagnosis.answers.suspect_results import exclusion_lines
from stiffcal.escapes import toml_text
from tests.laboratory.offered_toml import faults_in, offers_in
from tests.laboratory.printed_toml import HOLE, pairs_in, wrong_toml

NAMES = ("X (mm)", "t [s]", "a.b", 'the "5"', "it's", "A and B", "x`y", "Kraft Fx, N", "größe", "", "\x7f\u202e")
_CODE = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")


def test_every_line_in_the_prose_of_the_docs_parses() -> None:
    wrong = []
    for page in hand_written_pages():
        prose = re.sub(r"^```.*?^```", "", page_text(page), flags=re.DOTALL | re.MULTILINE)
        wrong += [f"{page}: {piece}" for code in _CODE.findall(prose) for piece in wrong_toml(code)]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", NAMES)
def test_any_name_can_be_pasted(name: str) -> None:
    assert tomllib.loads(toml_text.pair(name, {name: [name, 1, 2.5, True]})) == {name: {name: [name, 1, 2.5, True]}}
    lines = "\n".join(exclusion_lines(name, [1, 2], name, name))
    assert tomllib.loads(lines)["exclude"] == [
        {"source": name, "rows": [1, 2], "why": name, **({"run": name} if name else {})}
    ]


@pytest.mark.parametrize("name", [name for name in NAMES if name])
def test_a_condition_on_rows_can_be_pasted_whatever_the_column_is_called(name: str) -> None:
    line = toml_text.pair("rows", f"{condition_text(name, '!=', 0)} and {condition_text(name, '==', name)}")
    assert parse_rows(tomllib.loads(line)["rows"]) == (RowCondition(name, "!=", 0.0), RowCondition(name, "==", name))


def test_the_scanner_finds_what_cannot_be_pasted() -> None:
    assert list(pairs_in('write position = ["A1", "A[2]"] or motor = true; p = 0.1')) == [
        'position = ["A1", "A[2]"]',
        "motor = true",
    ]
    for text in (
        "files = { … }",
        f'rows = "{HOLE} != 0"',
        f"markers = {{ {HOLE} = 1 }}",
        "columns = [x",
        "at = [low, high]",
    ):
        assert list(wrong_toml(text)), text


def test_what_is_offered_is_taken_by_the_reader_of_its_file() -> None:
    block = 'to exclude them:\n  [[exclude]]\n  source = "table"\n  rows = [3]\n  why = "lost"\nnext: stiffcal run'
    assert list(offers_in(block)) == ['[[exclude]]\nsource = "table"\nrows = [3]\nwhy = "lost"']
    for text in (block, 'write rows = "X != 0"', "clock_ahead_s = { digitizer = 0.0 }", 'csv = { delimiter = ";" }'):
        assert faults_in(text) == []
    for text in ('write roows = "X != 0"', "holdout = 3", "[[exclude]]\nsource = 'table'\nrow = [3]"):
        assert len(faults_in(text)) == 1
