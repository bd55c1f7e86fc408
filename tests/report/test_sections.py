"""What single sections say: stiffness with its uncertainty, what stays open, noise, where the model fails."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.report.blocks import Facts, ReportSection, TableBlock, TableColumn
from stiffcal.report.building import _without_empty_columns
from stiffcal.report.content import ReportRun
from stiffcal.report.fit_sentences import noise_sentence
from stiffcal.report.sections import all_sections, not_identified, residuals, stiffness, summary
from stiffcal.report.sections.campaign import runs_table
from tests.laboratory.fits import validation_of, with_fit, with_validation
from tests.laboratory.report_content import made_up_content


def compliance(**changes: Any) -> dict[str, Any]:
    """A well known joint compliance in the form of the identify document."""
    return {
        "name": "joint-compliance.j2.c", "effect": "joint-compliance", "where": {"joints": [2]}, "value": 2e-6,
        "std": 2e-8, "interval": [1.9608e-6, 2.0392e-6], "unit": "rad/(N·m)", "fixed": False, "identifiable": True,
        "stiffness": 5e5, "stiffness_std": 5e3, "stiffness_interval": [490388.0, 509996.0],
    } | changes  # fmt: skip


def table_of(parameter: dict[str, Any]) -> TableBlock:
    content = made_up_content(n_runs=1)
    made = stiffness.section(with_fit(content, parameters=[parameter]))
    assert isinstance(made, ReportSection)
    (table,) = [block for block in made.blocks if isinstance(block, TableBlock)]
    return table


def cells(parameter: dict[str, Any]) -> list[str]:
    return list(table_of(parameter).rows[0])


@pytest.mark.parametrize("unit", ["rad/(N·m)", "rad/(N*m)"])
def test_stiffness_with_both_ways_to_write_its_unit(unit: str) -> None:
    assert cells(compliance(unit=unit)) == [
        "joint 2 (A2)", "joint-compliance", "(5.000 ± 0.098)·10⁵", "1.0",
    ]  # fmt: skip


def test_a_lopsided_interval_is_given_by_its_ends() -> None:
    found = cells(compliance(stiffness_std=2e5, stiffness_interval=[2.8e5, 2.3e6], poorly_known=True))
    assert found[2] == "5.0 (2.8 … 23.0)·10⁵"
    assert found[4:] == ["poorly determined"]
    assert "Poorly determined: joint 2 (A2)" in table_of(compliance(poorly_known=True)).caption


def test_no_upper_bound_is_said() -> None:
    found = cells(compliance(stiffness_std=6e5, stiffness_interval=[2.8e5, None], poorly_known=True))
    assert found[2] == "5.00 (above 2.80)·10⁵"
    assert found[4:] == ["poorly determined, no upper bound"]


def test_parameters_without_a_value_are_dashes_never_numbers() -> None:
    nothing = dict.fromkeys(("value", "std", "interval", "stiffness", "stiffness_std", "stiffness_interval"))
    found = cells(compliance(identifiable=False, **nothing))
    assert found[2:] == ["not identifiable", "–"]


def test_fixed_parameter_has_no_uncertainty() -> None:
    found = cells(compliance(fixed=True, std=None, interval=None, stiffness_std=None, stiffness_interval=None))
    assert found[2:] == ["5.00·10⁵ (fixed)", "–"]


def test_parameter_that_is_no_stiffness_has_its_own_unit() -> None:
    play = {
        "name": "backlash.j4.width", "effect": "backlash", "where": {"joints": [4]}, "value": 1.8e-3, "std": 1e-4,
        "interval": [1.604e-3, 1.996e-3], "unit": "rad", "fixed": False, "identifiable": True,
    }  # fmt: skip
    assert cells(play) == ["backlash.j4.width", "joint 4", "1.80 ± 0.20", "mrad"]


def test_open_and_hardly_known_parameters_are_named() -> None:
    content = made_up_content(n_runs=1)
    open_one = compliance(identifiable=False, value=None)
    reason = {"parameters": ["a", "b"], "known": "a + b", "reason": "the base's turn about z is joint 1's"}
    made = with_fit(content, parameters=[open_one], not_identifiable=[reason])
    text = repr(not_identified.section(made))
    assert "the base's turn about z is joint 1's" in text
    assert "joint-compliance.j2.c (joint 2 (A2)): no value" in text
    made = with_fit(content, parameters=[compliance(poorly_known=True)], not_identifiable=[])
    text = repr(not_identified.section(made))
    assert "poorly determined, 95 % between 4.90·10⁵ and 5.10·10⁵ N·m/rad" in text


def test_noise_is_given_or_said_to_be_unknown() -> None:
    known = validation_of(noise={"translation": 2.77e-5, "rotation": None})
    assert "0.0277 mm rms" in noise_sentence(known)
    for nothing in (None, {"translation": None, "rotation": None}):
        assert "noise is unknown" in noise_sentence(validation_of(noise=nothing))


def test_thresholds_that_do_not_hold_are_said() -> None:
    content = made_up_content(n_runs=1)
    failed = with_validation(content, passed=False)
    assert "thresholds of the campaign are exceeded" in repr(summary.section(failed))
    assert "thresholds of the campaign are exceeded" not in repr(summary.section(content))


def test_one_bad_run_is_named() -> None:
    content = made_up_content()
    by_run = [
        {
            "label": name,
            "low": None,
            "high": None,
            "n": 9,
            "rms": {"translation": rms, "rotation": None},
            "max": {"translation": 2 * rms, "rotation": None},
        }
        for name, rms in (("good", 2e-5), ("bad", 9e-5))
    ]
    text = repr(residuals.section(with_validation(content, by_run=by_run)))
    assert "largest 0.0900 mm rms (run bad), smallest 0.0200 mm (run good), a factor of 4.5" in text


def test_sections_stand_in_a_fixed_order() -> None:
    orders = [module.ORDER for module in all_sections()]
    assert orders == sorted(set(orders))
    assert len(orders) >= 11


def test_the_share_of_geometry_has_a_column_where_it_is_known() -> None:
    assert "share of\ngeometry" not in [column.title for column in table_of(compliance()).columns]
    table = table_of(compliance(from_geometry=0.27))
    assert "share of\ngeometry" in [column.title for column in table.columns]
    assert cells(compliance(from_geometry=0.27))[4] == "27"


def test_a_report_without_a_diagnosis_asks_for_one_also_within_the_noise() -> None:
    noise = {"translation": 1.0, "rotation": 1.0}
    made = summary.section(with_validation(made_up_content(n_runs=1), noise=noise))
    assert isinstance(made, ReportSection)
    (facts,) = [block for block in made.blocks if isinstance(block, Facts)]
    assert dict(facts.rows)["next step"] == "stiffcal diagnose DIR"


@pytest.mark.parametrize("measures", [StateMeasure.DISPLACEMENT, StateMeasure.PLACE])
def test_runs_without_a_pose_are_no_rows_of_dashes(measures: StateMeasure) -> None:
    content = made_up_content(n_runs=2)
    bare = ReportRun("turning", np.full(3, np.nan))
    runs = tuple(replace(run, measures=measures) for run in (*content.runs, bare))
    table = runs_table(replace(content, runs=runs, states=None))
    assert [row[0] for row in table.rows] == ["run_0", "run_1"]
    assert "turning" in table.caption


def test_a_column_in_which_no_row_has_anything_is_not_set() -> None:
    columns = (TableColumn("joint"), TableColumn("stribeck"), TableColumn("viscous"))
    table = TableBlock(columns, (("A1", "–", "3"), ("A2", "", "–")), "", doubtful=((0, 2),))
    shown = _without_empty_columns(table)
    assert [column.title for column in shown.columns] == ["joint", "viscous"]
    assert shown.rows == (("A1", "3"), ("A2", "–"))
    assert shown.doubtful == ((0, 1),)
