"""Without `--details`, answers say once what belongs together: a row a vector, a row for runs that are alike."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO

import pytest

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_page
from stiffcal.identification.answers.geometry_results import GeometryFound
from stiffcal.ingest.checks.results import CheckedColumn, CheckedRun, CheckedSource, CheckResult
from stiffcal.measurements.rms import Rms
from stiffcal.presentation.texts import printed_rows
from stiffcal.presentation.values import Overview, Sentence, Table
from stiffcal.show.answers.check import MOST_RUNS, REPORT_ASKED, _add_ranges, _add_runs, _moved, page
from stiffcal.show.answers.identify import add_overviews, fit_verdict
from stiffcal.show.answers.identify import page as fit_page
from stiffcal.show.answers.validate import _add_slices
from stiffcal.show.builder import PageBuilder
from stiffcal.show.options import PLAIN
from stiffcal.show.parameters import add_parameters
from stiffcal.validation.results import ErrorSlice
from tests.laboratory.fits import with_fit
from tests.laboratory.report_content import made_up_content


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
    assert len(_run_rows([*range(90, 90 + MOST_RUNS + 2)])) == MOST_RUNS
    assert len(_run_rows([*range(90, 90 + MOST_RUNS + 2)], details=True)) == MOST_RUNS + 2


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
    draw_page(console, page(result, PLAIN))
    assert (REPORT_ASKED in stream.getvalue()) is asked


@pytest.mark.parametrize(("details", "n_lines"), [(False, MOST_RUNS), (True, MOST_RUNS + 2)])
def test_details_hold_every_line_of_what_was_set_aside(details: bool, n_lines: int) -> None:
    """Of one run a single line was left of them."""
    lines = [f"state {k}: bumped" for k in range(MOST_RUNS + 2)]
    run = CheckedRun(
        id="pose1", experiment="load", n_states=9, largest_force_N=1.0, set_aside=lines, clock_ahead_s={}
    )  # fmt: skip
    made = PageBuilder("")
    _add_runs(made, [run], details)
    codes = [block.code for block in made.page().blocks if isinstance(block, Sentence)]
    assert codes == ["set-aside"] * n_lines + ["more"] * (not details)


@pytest.mark.parametrize(("errors", "n_rows"), [([1e-4, 1.1e-4], 0), ([1e-4, 1.3e-4], 2)])
def test_errors_that_are_nearly_alike_are_no_table(errors: list[float], n_rows: int) -> None:
    parts = [
        ErrorSlice(label=str(k), low=None, high=None, n=9, rms=Rms(rms, None), max=Rms(2.0 * rms, None))
        for k, rms in enumerate(errors)
    ]
    for most, expected in ((3, n_rows), (None, 2)):
        made = PageBuilder("")
        _add_slices(made, "branch", parts, "the deflection", most)
        assert len(_rows(made)) == expected


@pytest.mark.parametrize("details", [False, True])
def test_single_runs_of_a_kind_are_details(details: bool) -> None:
    made = PageBuilder("")
    add_overviews(made, [Overview((Sentence(("of all",), "all"),), (Sentence(("of a run",), "run"),))], details)
    codes = [block.code for block in made.page().blocks if isinstance(block, Sentence)]
    assert codes == ["all", "run" if details else "more"]


def test_a_model_of_many_values_lists_some() -> None:
    content = with_fit(made_up_content(n_runs=1), parameters=[_value(k) for k in range(9)])
    assert content.identify is not None
    parameters = content.identify.parameters
    for most, listed in ((4, 4), (8, 9), (None, 9)):
        made = PageBuilder("")
        add_parameters(made, parameters, most=most)
        assert len(_rows(made)) == listed


@pytest.mark.parametrize(("cause", "verdict"), [("same-motion", "all parameters are"), ("dependent", "1 parameter is")])
def test_what_is_a_convention_is_no_failure(cause: str, verdict: str) -> None:
    """What other poses would determine is none: of eight poses all parameters were called identifiable."""
    frame = _value(1) | {"name": "frame.tracker.z", "effect": "frame", "value": None, "identifiable": False}
    left = [{"parameters": ["frame.tracker.z"], "known": None, "reason": "", "cause": cause}]
    content = with_fit(made_up_content(n_runs=1), parameters=[_value(2), frame], not_identifiable=left)
    assert content.identify is not None
    assert "1 parameter is" in fit_verdict(content.identify)[1]
    rows = GeometryFound(convention="dh", zeros=[], links=[], beta=[], offsets_alone=None)
    found = replace(content.identify, geometry=rows)
    assert verdict in fit_verdict(found)[1]
    codes = [block.code for block in fit_page(found, PLAIN).blocks if isinstance(block, Sentence)]
    assert ("not-identifiable" in codes) is (cause == "dependent")


def _value(k: int) -> dict[str, object]:
    return {
        "name": f"backlash.j{k}.width", "effect": "backlash", "where": {"joints": [k]}, "value": 1e-3, "std": 1e-5,
        "interval": [0.98e-3, 1.02e-3], "unit": "rad", "fixed": False, "identifiable": True,
    }  # fmt: skip
