"""Without `--details`, answers say once what belongs together: a row a vector, a row for runs that are alike."""

from __future__ import annotations

from io import StringIO

import pytest

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_page
from stiffcal.ingest.checks.results import CheckedColumn, CheckedRun, CheckedSource, CheckResult
from stiffcal.presentation.texts import printed_rows
from stiffcal.presentation.values import Table
from stiffcal.show.answers.check import REPORT_ASKED, _add_ranges, _add_runs, _moved, page
from stiffcal.show.builder import PageBuilder


def _rows(made: PageBuilder) -> list[tuple[str, ...]]:
    return [row for block in made.page().blocks if isinstance(block, Table) for row in printed_rows(block)]


def _column(signal: str, name: str, high: float, unit: str = "N") -> CheckedColumn:
    return CheckedColumn(signal=signal, column=name, unit=unit, low_si=-1.0, high_si=high, moved=high > -1.0)


COLUMNS = [
    *(_column("joints", f"A{k}", 0.1 * k, "deg") for k in (1, 2)),
    *(_column("wrench", name, size) for name, size in (("Fx", 10.0), ("Fy", 20.0), ("Fz", -1.0))),
]
SOURCE = CheckedSource(source="table", file="t.csv", rows=9, columns=COLUMNS, sampled=False)


def test_a_vector_is_one_row_and_each_joint_its_own() -> None:
    made = PageBuilder("")
    _add_ranges(made, [SOURCE], details=False)
    rows = _rows(made)
    assert [row[1:3] for row in rows] == [("joints", "A1"), ("joints", "A2"), ("wrench", "Fx … Fz")]
    assert (rows[-1][5], rows[-1][-1]) == ("20.00", "not Fz")
    made = PageBuilder("")
    _add_ranges(made, [SOURCE], details=True)
    assert len(_rows(made)) == len(COLUMNS)


@pytest.mark.parametrize(
    ("written", "shown"), [("rad", ("57.30", "°")), ("ms", ("1.000", "s")), ("urad", ("57.30", "°"))]
)
def test_a_range_has_the_unit_that_is_printed_next_to_it(written: str, shown: tuple[str, str]) -> None:
    made = PageBuilder("")
    column = _column("hold", "t", 1.0, written)
    _add_ranges(made, [CheckedSource(source="table", file="t.csv", rows=9, columns=[column], sampled=False)], False)
    assert _rows(made)[0][5:7] == shown


def test_columns_that_did_not_move_are_named() -> None:
    assert _moved(["Fx", "Fy", "Fz"], COLUMNS[2:]) == "not Fz"
    assert _moved(["Fx", "Fy"], COLUMNS[2:4]) == "yes"
    assert _moved(["Fz"], COLUMNS[4:]) == "no"


def _run_rows(states: list[int], details: bool = False) -> list[tuple[str, ...]]:
    runs = [
        CheckedRun(
            id=f"pose{k}", experiment="load", n_states=n, largest_force_N=100.0 * k, set_aside=[], clock_ahead_s={}
        )
        for k, n in enumerate(states, 1)
    ]
    made = PageBuilder("")
    _add_runs(made, runs, details=details)
    return _rows(made)


def test_runs_that_are_alike_are_one_row() -> None:
    rows = _run_rows([97, 97, 96])
    assert [row[0] for row in rows] == ["pose1, pose2", "pose3"]
    assert rows[0][-1] == "100 … 200"
    assert [row[0] for row in _run_rows([97, 97, 97])] == ["pose1 … pose3: 3 runs"]
    rows = _run_rows([97, 97, 96], details=True)
    assert [row[0] for row in rows] == ["pose1", "pose2", "pose3"]
    assert not any("…" in row[0] for row in rows)


def test_a_row_holds_neighbours_alone() -> None:
    rows = _run_rows([97, 96, 97])
    assert [row[0] for row in rows] == ["pose1", "pose2", "pose3"]


@pytest.mark.parametrize(
    ("states_report", "at_terminal", "asked"), [(False, True, True), (True, True, False), (False, False, False)]
)
def test_whose_robot_it_is_is_asked_until_the_campaign_has_a_report(
    states_report: bool, at_terminal: bool, asked: bool
) -> None:
    stream = StringIO()
    console = AnswerConsole(file=stream, width=300, force_terminal=at_terminal, color_system=None, markup=False)
    result = CheckResult(
        warnings=[], campaign="cell", sources=[], runs=[], kinematics=None, n_states=0, ready=True, missing=[],
        states_report=states_report,
    )  # fmt: skip
    draw_page(console, page(result, False))
    assert (REPORT_ASKED in stream.getvalue()) is asked
