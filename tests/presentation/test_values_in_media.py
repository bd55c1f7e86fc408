"""One value, one writing: a table of values goes through terminal, report, page, notebook and documents."""

from __future__ import annotations

from io import StringIO
from typing import Any

import pytest

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.tables import show_parameters
from stiffcal.documents import document_of, result_from_values
from stiffcal.identification.answers.before_after import estimated_parameters
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.model.summary import Where
from stiffcal.presentation.texts import printed_columns, printed_rows
from stiffcal.presentation.values import Column, Table
from stiffcal.python.answers import parameter_lines
from stiffcal.report.sections.stiffness import other_table
from stiffcal.results.value_words import as_shown
from stiffcal.view.gathering.models import _values

VALUES: dict[str, tuple[dict[str, Any], str, str]] = {
    "value": ({"value": 1.2345e-3, "interval": None}, "1.23", ""),
    "±": ({"value": 2e-3, "std": 1e-5, "interval": [1.98e-3, 2.02e-3]}, "2.000 ± 0.020", ""),
    "small": ({"value": 3e-6, "std": 1e-7, "interval": [2.8e-6, 3.2e-6]}, "0.00300 ± 0.00020", ""),
    "negative": ({"value": -2e-3, "interval": [-2.2e-3, -1.8e-3]}, "−2.00 ± 0.20", ""),
    "lopsided": ({"value": 2e-3, "interval": [1e-3, 9e-3]}, "2.0 (1.0 … 9.0)", ""),
    "poor": (
        {"value": 2e-3, "interval": [1e-4, 9e-3], "poorly_known": True}, "2.0 (0.1 … 9.0)", "poorly determined",
    ),
    "open": ({"value": 2e-3, "interval": [1e-3, None], "at_bound": True}, "2.00 (above 1.00)", "at its limit"),
    "rests": ({"value": 2e-3, "interval": [1.9e-3, 2.1e-3], "rests_on": ["a.b.c"]}, "2.00 ± 0.10", "with a.b.c at"),
    "faint": ({"value": 2e-5, "interval": [0.0, 4e-5], "above_noise": False}, "0.020 ± 0.020", "not significant"),
    "fixed": ({"value": 2e-3, "interval": None, "fixed": True}, "2.00 (fixed)", ""),
    "none": ({"value": None, "interval": None, "identifiable": False}, "not identifiable", ""),
    "shifted": ({"value": 2e-3, "interval": [1.9e-3, 2.1e-3]}, "2.00 ± 0.10", "shifted by what the model lacks"),
}  # fmt: skip


def parameter(name: str, changes: dict[str, Any]) -> IdentifiedParameter:
    known: dict[str, Any] = {"std": None, "fixed": False, "identifiable": True} | changes
    return IdentifiedParameter(
        name=f"backlash.{name}.w", effect="backlash", where=Where(joints=[4]), unit="rad", **known
    )


@pytest.fixture(scope="module")
def parameters() -> list[IdentifiedParameter]:
    return [parameter(name, changes) for name, (changes, _, _) in VALUES.items()]


def terminal(parameters: list[IdentifiedParameter], shifted: list[str]) -> list[str]:
    text = StringIO()
    show_parameters(AnswerConsole(file=text, width=200), parameters, (), shifted)
    return text.getvalue().splitlines()[2:]


def report(parameters: list[IdentifiedParameter], shifted: list[str]) -> list[str]:
    shown = {one.name: as_shown(one, (), shifted) for one in parameters}
    return ["  ".join(row) for row in other_table(parameters, (), shown).rows]


def page(parameters: list[IdentifiedParameter], shifted: list[str]) -> list[str]:
    shown = _values({one.name: as_shown(one, (), shifted) for one in parameters})
    return [f"{value.name} {value.text} {value.unit}" for value in shown]


def notebook(parameters: list[IdentifiedParameter], shifted: list[str]) -> list[str]:
    return parameter_lines(parameters, shifted)


@pytest.mark.parametrize("medium", [terminal, report, page, notebook])
def test_a_value_reads_the_same_in_every_medium(medium: Any, parameters: list[IdentifiedParameter]) -> None:
    lines = medium(parameters, ["backlash.shifted.w"])
    for line, (name, (_, text, remark)) in zip(lines, VALUES.items(), strict=True):
        own = line.partition(f"backlash.{name}.w")[2]
        assert text in own, name
        assert ("mrad" in own) or text == "not identifiable", name
        assert remark in own, name
        assert ("shifted" in own) == (name == "shifted"), name


def test_documents_hold_si_values_and_what_is_to_be_known_of_them(parameters: list[IdentifiedParameter]) -> None:
    for one, (changes, _, _) in zip(parameters, VALUES.values(), strict=True):
        document = document_of(one)
        assert {key: document[key] for key in changes} == changes
        assert document["unit"] == "rad"
        assert result_from_values(IdentifiedParameter, document) == one
    # an answer's values before and after have the keys of the interface and no more
    (estimate,) = (one.estimate for one in estimated_parameters([parameters[1]]))
    assert document_of(estimate) == {"value": 2e-3, "interval": [1.98e-3, 2.02e-3], "at_bound": False}


@pytest.mark.parametrize(
    ("largest", "unit", "texts"), [(2e-3, "mrad", ["2.00", "0.00300"]), (4e-6, "µrad", ["4.00", "3.00"])]
)
def test_a_column_has_one_unit_by_its_largest_number(largest: float, unit: str, texts: list[str]) -> None:
    pair = [parameter("a", {"value": largest, "interval": None}), parameter("b", {"value": 3e-6, "interval": None})]
    for medium in (terminal, report, page, notebook):
        assert all(unit in line and text in line for line, text in zip(medium(pair, []), texts, strict=True))
    table = Table((Column("width", "rad"),), tuple((((as_shown(one)),),) for one in pair))
    assert [unit_name for _, unit_name in printed_columns(table)] == [unit]
    assert [row[0] for row in printed_rows(table)] == texts
