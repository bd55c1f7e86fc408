"""One stiffness and one play of a clamped joint, each in one unit, and no torque that was not reached."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from stiffcal.kinds.clamped.answers.documents import DEFINITION, joint_result, run_result
from stiffcal.kinds.clamped.answers.joints import joints_of
from stiffcal.kinds.clamped.answers.page import AT_SEARCH_LIMIT, LOW_SLOPE, clamped_overview
from stiffcal.kinds.clamped.answers.results import ClampedRunResult, ClampedSection, Definition, JointResult
from stiffcal.kinds.clamped.loops.torque_angle_fit import CURVE
from stiffcal.presentation.texts import text_of
from stiffcal.presentation.values import Column, Sentence, Table
from stiffcal.uncertainty import NORMAL_95
from tests.laboratory.clamped_runs import clamped_run
from tests.laboratory.torque_angle_laws import clamped_law


def test_the_common_curve_promises_no_torque_that_was_not_reached() -> None:
    """Where one run has no play, its angles from the flank go further; the other's curve is steeper out there."""
    law = clamped_law(3)[0]
    p1 = law.curve[0]
    hard = replace(law, curve=(p1, 0.0, 40.0 * p1 / law.reach[1] ** 2))
    soft = replace(law, width=0.0, curve=(0.5 * p1, 0.0, 0.0), reach=(1.6 * law.reach[0], 1.6 * law.reach[1]))
    runs = [clamped_run("hard", hard, seed=1, noise=0.1), clamped_run("soft", soft, seed=2, noise=0.1)]
    (joint,) = joints_of(runs)
    measured = max(float(np.abs(run.branches.torque - run.fit.law.zero).max()) for run in runs)
    x = np.array(joint.reach)
    ends = np.stack([x, x**2, x**3], axis=1) @ joint.coefficients
    farthest = max(run.fit.law.reach[1] for run in runs)
    promised = np.array([farthest, farthest**2, farthest**3]) @ joint.coefficients
    assert promised > 1.2 * measured, "the test has no power where the curve stays below what was measured"
    assert np.abs(joint.torque).max() <= measured
    assert np.abs(ends).max() == pytest.approx(np.abs(joint.torque).max(), rel=1e-2)


def section() -> ClampedSection:
    law = clamped_law(3, friction=12.0)[0]
    runs = [clamped_run("wide", law), clamped_run("narrow", law, seed=2, reversal=0.01)]
    for run in runs:
        chain: Any = run.chain
        chain.lever, chain.weight = float("nan"), 0.0
    (joint,) = joints_of(runs)
    return ClampedSection(
        definition=DEFINITION, joints=[joint_result(joint, "A3")], runs=[run_result(run) for run in runs]
    )


def test_each_quantity_has_one_unit_and_each_run_its_reversal_error() -> None:
    overview = clamped_overview(section())
    (joints,), (runs, *sentences) = overview.blocks, overview.details
    assert isinstance(joints, Table)
    assert isinstance(runs, Table)
    units = {column.title: column.unit for column in (*joints.columns, *runs.columns) if isinstance(column, Column)}
    assert units["chord stiffness"] == "N·m/rad"
    # as backlash's width
    assert units[LOW_SLOPE] == units["reversal error"] == "rad"
    assert [str(row[0][0]) for row in runs.rows] == ["wide", "narrow"]
    assert [one.code for one in sentences if isinstance(one, Sentence)] == ["joint", *["definition"] * 3]


def test_a_description_is_no_second_play() -> None:
    """That is a parameter of the model, next to which the description stands."""
    joints = next(block for block in clamped_overview(section()).blocks if isinstance(block, Table))
    titles = [str(column.title) for column in joints.columns if isinstance(column, Column)]
    assert titles[0] == "clamped, without a model, ± 95 %"
    assert not [title for title in titles if "play" in title]
    names = [field.name for result in (JointResult, ClampedRunResult, Definition) for field in fields(result)]
    assert not [name for name in names if "play" in name]


def test_a_band_as_wide_as_the_search_allows_is_at_its_limit() -> None:
    law = clamped_law(3)[0]
    wide = replace(law, band=0.2 * float(law.spring(np.array(law.reach))[1]))
    assert clamped_run("soft", wide, noise=0.1).fit.at_limit == {"band": (False, True)}
    assert clamped_run("usual", law, noise=0.1).fit.at_limit == {}


def test_a_curve_at_the_limit_of_its_range_has_no_uncertainty() -> None:
    run = clamped_run("straight", clamped_law(3, width=0.0)[0])
    run = replace(run, fit=replace(run.fit, at_limit=dict.fromkeys(CURVE, (True, True))))
    (joint,) = joints_of([run])
    assert {one.spec.symbol for one in joint.parameters if one.at_bound} == {
        "low_slope",
        "width",
        "p1",
        "p2",
        "p3",
        "chord",
    }
    assert [one.std for one in joint.curve] == [None] * 3
    result = joint_result(joint, "A3")
    assert result.at_bound == ["p1", "p2", "p3", "chord"]
    assert result.chord_interval == [None, None]
    table = next(
        block for block in clamped_overview(ClampedSection(definition=DEFINITION, joints=[result], runs=[])).blocks
    )
    assert isinstance(table, Table)
    assert text_of(table.rows[0][1]).endswith(f", {AT_SEARCH_LIMIT}")
    assert "±" not in text_of(table.rows[0][1])
    assert all(tangent.interval == [None, None] for tangent in result.tangent_stiffness if tangent.stiffness)
    # of a play that is none what it may be at most is known
    assert result.low_slope_std is None
    assert result.low_slope_interval == [0.0, pytest.approx(NORMAL_95 * 0.5 * run.resolution)]


def test_intervals_of_a_description_are_those_of_its_standard_uncertainties() -> None:
    (joint,) = joints_of([clamped_run("wide", clamped_law(3, friction=12.0)[0])])
    result = joint_result(joint, "A3")
    assert result.at_bound == []
    assert result.low_slope_std is not None
    half = NORMAL_95 * result.low_slope_std
    assert result.low_slope_interval == pytest.approx([result.low_slope - half, result.low_slope + half])
    assert joint.friction is not None
    assert joint.friction.interval == pytest.approx([12.0, 12.0], abs=2.0)
    spread = np.sqrt(np.diagonal(joint.covariance))
    assert [one.std for one in joint.curve] == pytest.approx(spread.tolist())
