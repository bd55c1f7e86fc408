"""Reports of absolute poses: columns that are always the same are left out, long names do not overlap."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pypdf import PdfReader

from stiffcal.measurements.rms import Rms
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.quantity import JOINT_ANGLE
from stiffcal.report import building
from stiffcal.report.blocks import ReportSection, TableBlock
from stiffcal.report.content import ReportContent
from stiffcal.report.gathering import content as report_content
from stiffcal.report.sections import agreement, calibration, load_deformation, residuals, run_table
from stiffcal.report.sections.campaign import runs_table
from stiffcal.validation.distance_results import Distances, DistanceSummary, RegionDistance
from stiffcal.validation.results import ErrorSlice
from tests.laboratory.fits import with_validation
from tests.laboratory.report_content import made_up_content

UR = ("left_shoulder_pan_joint", "left_shoulder_lift_joint", "left_elbow_joint")


def poses(n: int, load: float = 0.0) -> ReportContent:
    """Return content of n poses of an absolute run, the last angle a little below zero."""
    content = made_up_content(n_runs=n, per_run=1)
    assert content.states is not None
    joints = np.array([0.5, -1.0, -1e-5])
    runs = tuple(
        replace(run, name=f"poses row {k + 1}", measures=StateMeasure.PLACE, joints=joints)
        for k, run in enumerate(content.runs)
    )
    states = replace(content.states, load=np.full(len(content.states), load))
    return replace(content, runs=runs, states=states)


def worst_table(content: ReportContent) -> TableBlock:
    made = residuals.section(content)
    assert isinstance(made, ReportSection)
    return [block for block in made.blocks if isinstance(block, TableBlock)][-1]


def test_poses_without_load_are_listed_by_angles_and_distance() -> None:
    table = runs_table(poses(3))
    assert [column.title for column in table.columns] == ["run", "A1", "A2", "A3", "from the nominal robot"]
    assert table.rows[0][:4] == ("poses\u00a0row\u00a01", "28.6", "−57.3", "0.0")
    assert "loads" not in table.caption
    assert "largest load" in [column.title for column in runs_table(poses(3, load=50.0)).columns]
    assert "states" in [column.title for column in runs_table(made_up_content()).columns]


def test_places_and_loads_have_a_column_each() -> None:
    content = poses(3)
    first, *others = content.runs
    table = runs_table(replace(content, runs=(replace(first, measures=StateMeasure.DISPLACEMENT), *others)))
    assert [column.title for column in table.columns][-2:] == ["largest deflection", "from the nominal robot"]
    assert [[cell == "–" for cell in row[-2:]] for row in table.rows] == [[False, True], *[[True, False]] * 2]


def test_ranges_of_angles_have_no_minus_zero_and_regions_have_their_joints() -> None:
    part = ErrorSlice(label="", n=3, rms=Rms(1e-5, None), max=Rms(1e-5, None), low=-0.6, high=-1e-3)
    assert residuals.short_ranges([part], JOINT_ANGLE.usual)[0].label == "−34 … 0"
    assert residuals.ranges_of_joints([part]) == ["−34° to 0°"]
    region = RegionDistance(1, 1e-4, 1e-4, 2e-4, 3e-4, 1e-4, 12, [-0.5, 1e-3, 1.2])
    summary = DistanceSummary(1e-4, 1e-4, 2e-4, 3e-4, 1e-4, 12, [])
    table = calibration.regions_table(Distances(summary, summary, summary, [region]))
    assert table.rows[0][-1] == "−29, 0, 69"
    assert (table.columns[-1].title, table.columns[-1].unit) == ("mean joint angles", "°")


def test_the_worst_states_have_loads_with_their_own_units() -> None:
    place = {"run": "poses row 7", "row": 7, "residual_m": 2e-4, "load": 0.0, "branch": ""}
    clamped = {"run": "hold", "row": 2, "residual_m": None, "residual_rad": 1e-3, "load": 12.0, "branch": ""}
    titles = [column.title for column in worst_table(with_validation(poses(3), worst=[place])).columns]
    assert titles == ["run", "row", "residual"]
    table = worst_table(with_validation(made_up_content(), worst=[{**place, "load": 300.0}, clamped]))
    assert [(column.title, column.unit) for column in table.columns][-1] == ("load", "")
    assert [row[-1] for row in table.rows] == ["300 N", "12.0 N·m"]
    assert table.rows[0][0] == "poses\u00a0row\u00a07"


def test_long_joint_names_break_in_the_header_and_the_contents_stay_whole(tmp_path: Path) -> None:
    content = replace(poses(60), joint_names=UR * 2)
    content = replace(content, runs=tuple(replace(run, joints=np.tile(run.joints, 2)) for run in content.runs))
    assert run_table.section(content) is not None
    building.build_report(content, tmp_path / "report.pdf")
    pages = [page.extract_text() for page in PdfReader(tmp_path / "report.pdf").pages]
    appendix = next(page for page in pages if "poses\u00a0row\u00a060" in page or "poses row 60" in page)
    assert "left_shoulder_pan_joint" not in appendix
    (front,) = [page for page in pages if "Contents" in page]
    assert front in pages[:2]
    assert "1 Summary" in front.replace("\n", " ")


def text_of(made: object) -> str:
    assert isinstance(made, ReportSection)
    return " ".join(getattr(block, "caption", "") or getattr(block, "text", "") for block in made.blocks)


def test_pages_of_places_state_distances_and_those_of_loads_deflections() -> None:
    places, loads = poses(3), made_up_content(n_runs=3, per_run=1)
    made = load_deformation.section(places)
    assert made.title == "Measured and predicted positions"
    assert "3 poses were measured, each once" in text_of(made)
    assert "Distance from the nominal position in each row" in text_of(made)
    assert "eflection" not in text_of(made) + text_of(agreement.section(places))
    assert "Deflection in each run" in text_of(load_deformation.section(loads))
    assert "displacement D" in text_of(agreement.section(loads))


def test_places_are_on_no_branch() -> None:
    worst = [
        {"run": f"poses row {k}", "row": k, "residual_m": 2e-4, "load": 49.0 * k, "branch": branch}
        for k, branch in enumerate(("unloaded", "peak"))
    ]
    assert "branch" not in [column.title for column in worst_table(with_validation(poses(3), worst=worst)).columns]
    loads = made_up_content(n_runs=3, per_run=1)
    assert "branch" in [column.title for column in worst_table(with_validation(loads, worst=worst)).columns]


def test_a_torque_that_is_rounding_is_no_possible_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Residuals follow the torque of joint 6, which is 1e-15 N·m in every pose, by chance the most."""
    rng = np.random.default_rng(3)
    torque = rng.normal(size=(40, 6)) * [0.0, 900.0, 500.0, 40.0, 20.0, 1e-14]
    residual = np.zeros((40, 6))
    residual[:, 0] = 1e13 * 1e-5 * torque[:, 5] + 1e-6 * rng.normal(size=40)
    monkeypatch.setattr(report_content, "joint_torques", lambda *_: torque)
    states = SimpleNamespace(residual=residual, used=np.ones(40, dtype=np.bool_))
    data = SimpleNamespace(campaign=SimpleNamespace(chain=SimpleNamespace(prismatic=np.zeros(6, dtype=np.bool_))))
    found = report_content.most_correlated_covariates(data, None, states)  # type: ignore[arg-type]
    assert {covariate.name for covariate in found} <= {f"torque on joint {joint}" for joint in (2, 3, 4, 5)}
    assert len(found) == 3
