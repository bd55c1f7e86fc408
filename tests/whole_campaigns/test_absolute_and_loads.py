"""campaigns/absolute-and-loads: places and load runs of one robot, which MuJoCo is, in one fit and one diagnosis."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.benchmarks.absolute_and_loads import compare
from tests.laboratory.absolute_and_loads import write_campaign
from tests.laboratory.mujoco_robot import Spring
from tests.laboratory.robots import six_axis_joints
from tests.whole_campaigns.conftest import CAMPAIGNS

# springs, and the geometry of the wrist
OF_THE_WRIST = """schema = "stiffcal/model/1"
[[effects]]
type = "joint-compliance"
joints = "all"
[[effects]]
type = "link-geometry"
joints = [5, 6]
"""
NAMES = [f"joint-compliance.j{joint}.c" for joint in range(1, 7)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("both") / "arm"
    shutil.copytree(CAMPAIGNS / "absolute-and-loads", target, ignore=shutil.ignore_patterns("store"))
    return target


@pytest.fixture(scope="module")
def fitted(folder: Path) -> IdentifyResult:
    return identify_campaign(folder)


def test_one_fit_finds_the_stiffness_that_was_hidden(fitted: IdentifyResult) -> None:
    truth = json.loads((CAMPAIGNS / "absolute-and-loads" / "truth.json").read_text(encoding="utf-8"))
    away = np.array([fitted.parameter(name).value or np.nan for name in NAMES]) - 1.0 / np.array(
        truth["joint_stiffness"]
    )
    chosen = [fitted.free_parameters.index(name) for name in NAMES]
    covariance = np.array(fitted.covariance, dtype=float)[np.ix_(chosen, chosen)]
    assert chi2.sf(float(away @ np.linalg.solve(covariance, away)), len(NAMES)) > 1e-3
    # 780 readings of the two kinds: 99.9 % of the reduced χ² lie within 0.17 of 1
    assert fitted.reduced_chi2 == pytest.approx(1.0, abs=0.17)


def test_the_rigid_robot_is_the_true_one(folder: Path, tmp_path: Path) -> None:
    """Places of the fitted and the true rigid robot in 1000 poses, after the best rigid motion: gauge-free."""
    truth = write_campaign(tmp_path / "again", 1)
    for name in ("places.csv", "loads.csv"):
        assert (tmp_path / "again" / "raw" / name).read_bytes() == (folder / "raw" / name).read_bytes()
    data = up_to_date_states(folder, RunContext())
    robot = placed_robot(data.campaign).with_values(
        {p.name: p.value for p in identify_campaign(folder).parameters if p.value is not None}
    )
    angles = truth.chain.model_angles(six_axis_joints(np.random.default_rng(8), 1000))
    target = data.states.setup.targets[0]
    shift = [robot.values()[f"frame.target.{axis}"] for axis in "xyz"]
    places = []
    for chain, place in ((robot.adjusted_chain, target.transform[:3, 3] + shift), (truth.chain, truth.target)):
        transform = target.transform.copy()
        transform[:3, 3] = place
        places.append(attached_poses(chain, angles, type(target)(target.body, transform))[0])
    found, true = (place - place.mean(axis=0) for place in places)
    left, _, right = np.linalg.svd(found.T @ true)
    turn = right.T @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ left.T
    away = np.sqrt(np.mean(np.sum((found @ turn.T - true) ** 2, axis=1)))
    # 27 numbers from 180 coordinates known to 20 µm leave 20 µm √3 √(27/180) = 13 µm, and a half of it beyond
    assert away < 20e-6


def test_both_kinds_agree_on_what_each_determines(fitted: IdentifyResult) -> None:
    (agreement,) = fitted.agreement or []
    assert (agreement.first, agreement.second) == ("loads", "absolute")
    assert agreement.agree
    assert {"joint-compliance.j2.c", "joint-compliance.j3.c"} <= {p.name for p in agreement.parameters}


def test_check_counts_both(folder: Path) -> None:
    checked = check_campaign(folder)
    assert checked.ready
    assert {(run.id, run.n_states) for run in checked.runs} >= {("places", 60), ("pull1", 25)}
    assert all((joint.expected_relative_std or 1.0) < 0.03 for joint in checked.joints or [])


def test_what_is_left_out_is_judged_by_kind(folder: Path, fitted: IdentifyResult) -> None:
    validation = validate_campaign(folder)
    errors = {part.label: part.rms.translation for part in validation.by_experiment or []}
    assert set(errors) == {"loads", "absolute"}
    assert validation.distance is not None
    assert validation.distance.heldout_region is not None
    assert errors["absolute"] == pytest.approx(validation.distance.heldout_region.rms)
    # the noise of a place is 35 µm; with the wrench's share that of a load is no other
    assert all(30e-6 < (error or 0.0) < 50e-6 for error in errors.values())
    # regions of places and, next to them, eight poses of loads
    assert validation.n_poses == 6 + 8
    assert [step.step for step in validation.ladder or []] == ["nominal", "frames", "offsets", "geometry", "springs"]


def test_nothing_is_missing_where_nothing_is(folder: Path, fitted: IdentifyResult) -> None:
    diagnosis = diagnose_campaign(folder)
    assert diagnosis.missing == []
    assert not diagnosis.unexplained
    assert diagnosis.adequate


@pytest.mark.practice
def test_errors_of_the_links_are_named_as_geometry(tmp_path: Path) -> None:
    """Next to springs alone, errors of lengths and angles would go into springs of links: here places show them."""
    write_campaign(tmp_path, 2)
    (tmp_path / "model.toml").write_text(OF_THE_WRIST, encoding="utf-8")
    diagnosis = diagnose_campaign(tmp_path)
    assert {effect.effect for effect in diagnosis.missing} == {"link-geometry"}
    # joint 1's belongs to the tracker
    assert sorted(joint for effect in diagnosis.missing for joint in effect.where.joints or []) == [2, 3, 4]
    assert not diagnosis.unexplained
    assert diagnosis.noise is not None
    # with all of it, what is left out is known to the noise
    assert (diagnosis.heldout_rms_with_missing or diagnosis.rms).translation == pytest.approx(
        diagnosis.noise.translation, rel=0.15
    )
    # each kind has an error of its own: a place is off by geometry, a displacement is not
    before = {kind.experiment: kind.before or 0.0 for kind in diagnosis.findings[0].by_experiment or []}
    assert before["absolute"] > 3.0 * before["loads"]


@pytest.mark.practice
def test_a_bearing_that_tilts_is_named_next_to_geometry(tmp_path: Path) -> None:
    write_campaign(tmp_path, 3, springs=(Spring(2, "turn", 8e5, (1.0, 0.0, 0.0)),))
    diagnosis = diagnose_campaign(tmp_path)
    # what gives at joint 2 or next to it, in the swing, is certain; which of the three is not
    (group,) = diagnosis.missing
    assert group.probability is not None
    assert group.probability > 0.95
    assert not group.firm
    assert [one.where.joints for one in diagnosis.undecided if one.effect == "bearing-tilt"] == [[2]]
    (finding,) = [
        finding for finding in diagnosis.findings if finding.effect == "bearing-tilt" and finding.where.joints == [2]
    ]
    kinds = {kind.experiment: kind for kind in finding.by_experiment or []}
    assert kinds["loads"].n_fell >= 6
    assert (kinds["loads"].after or 1.0) < (kinds["loads"].before or 0.0)


def test_both_together_are_better_than_each_alone(tmp_path: Path) -> None:
    """As `python -m tests.benchmarks.absolute_and_loads` shows over fifty seeds."""
    compared = compare(tmp_path / "arm", 4)
    assert compared.std_ratio.max() < 1.02
    assert compared.place_error[0] < compared.place_error[1]


def test_a_load_in_a_row_of_an_absolute_run_is_refused_where_the_sensor_was_zeroed(
    folder: Path, tmp_path: Path
) -> None:
    arm = Path(shutil.copytree(folder, tmp_path / "arm", ignore=shutil.ignore_patterns("store")))
    manifest = (arm / "campaign.toml").read_text(encoding="utf-8")
    # the last run of loads is declared a run of places
    (arm / "campaign.toml").write_text(
        manifest.replace('id = "pull8"', 'id = "pull8"\nexperiment = "absolute"'), encoding="utf-8"
    )
    with pytest.raises(InputError) as refused:
        identify_campaign(arm)
    (fault,) = refused.value.faults
    assert "pull8" in fault.place or "tared" in fault.place
