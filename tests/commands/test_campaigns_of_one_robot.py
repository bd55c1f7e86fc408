"""Absolute campaigns of one robot, measured by a tracker that stands elsewhere: compared, and judged by each other."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.compare import compare_campaigns
from stiffcal.commands.compensate import compensate_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.compensation.corrected_path import CompensateRequest
from stiffcal.compensation.path_forces import Forces
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from tests.laboratory.absolute_and_loads import N_PLACES, TRACKER_M, Truth, write_campaign
from tests.laboratory.robots import six_axis_joints


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Truth]:
    """Return a campaign of places and loads, one of places alone after the tracker was moved, and what is hidden."""
    first, second = tmp_path_factory.mktemp("robot") / "both", tmp_path_factory.mktemp("robot") / "places"
    truth = write_campaign(first, 6)
    write_campaign(second, 6)
    manifest = (second / "campaign.toml").read_text(encoding="utf-8")
    start, end = manifest.index("[sources.loads]"), manifest.index("[[runs]]")
    runs = manifest[end : manifest.index('[[runs]]\nid = "pull1"')]
    (second / "campaign.toml").write_text(manifest[:start] + runs, encoding="utf-8")
    rng = np.random.default_rng(9)
    joints = six_axis_joints(rng, N_PLACES)
    places = truth.places(load_campaign(first, check_files=False).chain, joints, np.zeros((N_PLACES, 6)))
    places = places @ rotation_from_vector(np.array([0.3, -0.1, 1.2])).T + [0.4, 2.0, -0.7]
    places = places + TRACKER_M * rng.normal(size=places.shape)
    rows = np.column_stack([20.0 * np.arange(N_PLACES), np.degrees(joints), 1e3 * places])
    lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
    text = "\n".join(["t,A1,A2,A3,A4,A5,A6,X,Y,Z", *lines]) + "\n"
    (second / "raw" / "places.csv").write_text(text, encoding="utf-8")
    for folder in (first, second):  # whichever test comes first
        identify_campaign(folder)
    return first, second, truth


@pytest.fixture(scope="module")
def campaigns(measured: tuple[Path, Path, Truth]) -> tuple[Path, Path]:
    return measured[:2]


def test_nothing_has_changed_but_where_the_tracker_stands(campaigns: tuple[Path, Path]) -> None:
    compared = compare_campaigns(*campaigns)
    assert compared.changed == []
    assert (compared.p_value_all or 0.0) > 1e-3
    names = [parameter.name for parameter in compared.parameters]
    # where registration puts the tracker decides of the links next to it
    assert names == [f"joint-compliance.j{joint}.c" for joint in range(1, 7)]
    assert compared.only_before == compared.only_after == []
    assert len(compared.warnings) == 1


def test_geometry_is_compared_with_no_campaign_that_estimates_the_tracker(
    campaigns: tuple[Path, Path], tmp_path: Path
) -> None:
    """Loads alone, in their registered frame, hold `link-geometry` that nothing determines."""
    loads = tmp_path / "loads"
    shutil.copytree(campaigns[0], loads, ignore=shutil.ignore_patterns("store"))
    manifest = (loads / "campaign.toml").read_text(encoding="utf-8")
    places = manifest.index('[[runs]]\nid = "places"')
    pulls = manifest.index('[[runs]]\nid = "pull1"')
    own = manifest.index("[sources.places]"), manifest.index("[sources.loads]")
    manifest = manifest[: own[0]] + manifest[own[1] : places] + manifest[pulls:]
    (loads / "campaign.toml").write_text(manifest, encoding="utf-8")
    for pair in ((campaigns[1], loads), (loads, campaigns[1])):
        compared = compare_campaigns(*pair)
        assert {row.effect for row in compared.before_after} == {"joint-compliance"}
        assert compared.only_before == compared.only_after == []
        assert compared.changed == []


def test_the_model_of_one_holds_in_the_other(campaigns: tuple[Path, Path]) -> None:
    judged = validate_campaign(campaigns[1], model=campaigns[0])
    # 35 µm are the noise of sixty places; the model and the frames are known to some 15 µm
    assert judged.rms.translation == pytest.approx(np.hypot(np.sqrt(3.0) * TRACKER_M, 15e-6), rel=0.2)
    assert judged.warnings == []
    back = validate_campaign(campaigns[0], model=campaigns[1])
    # weight turns neither of them: the pulls do
    (said,) = back.warnings
    assert "do not identify joint-compliance.j1.c, joint-compliance.j6.c: taken as rigid" in said
    errors = {part.label: part.rms.translation or np.nan for part in back.by_experiment or []}
    assert errors["absolute"] == pytest.approx(np.hypot(np.sqrt(3.0) * TRACKER_M, 15e-6), rel=0.25)


def test_a_model_without_geometry_is_no_judge_of_places(measured: tuple[Path, Path, Truth], tmp_path: Path) -> None:
    loads = Path(shutil.copytree(measured[0], tmp_path / "loads", ignore=shutil.ignore_patterns("store")))
    model = (loads / "model.toml").read_text(encoding="utf-8")
    (loads / "model.toml").write_text(model[: model.rindex("[[effects]]")], encoding="utf-8")
    identify_campaign(loads)
    judged = validate_campaign(measured[1], model=loads)
    assert (judged.rms.translation or 0.0) > 20.0 * TRACKER_M
    assert any("does not hold the robot's geometry" in text for text in judged.warnings)


PATH_DEG = np.linspace([-40.0, -70.0, 20.0, -40.0, 30.0, -60.0], [50.0, -40.0, 60.0, 60.0, 80.0, 70.0], 12)


def aligned(places: Floats, wanted: Floats) -> Floats:
    """Return (n,) distances of places (n, 3) to wanted ones after the rigid motion that fits best."""
    middle, goal = places.mean(axis=0), wanted.mean(axis=0)
    left, _, right = np.linalg.svd((places - middle).T @ (wanted - goal))
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return np.asarray(np.linalg.norm((places - middle) @ turn - (wanted - goal), axis=1))


@pytest.mark.parametrize("which", [0, 1])
def test_a_path_of_joint_angles_is_corrected_for_geometry_and_sag(
    measured: tuple[Path, Path, Truth], which: int, tmp_path: Path
) -> None:
    """The true robot stands where the robot file's rigid robot has the target, but for where the base is."""
    folder, truth = (measured[1] if which else measured[0]), measured[2]
    rows = ["A1,A2,A3,A4,A5,A6", *(",".join(f"{angle:.9g}" for angle in row) for row in PATH_DEG)]
    (tmp_path / "path.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    wish = CompensateRequest(tmp_path / "path.csv", Forces())  # geometry and weight alone need no forces
    corrected = compensate_campaign(folder, wish)
    assert corrected.wanted == "nominal robot"
    chain = load_campaign(folder, check_files=False).chain
    robot = fitted_robot(load_campaign(folder, check_files=False), RunContext())
    wanted, _ = attached_poses(chain, chain.model_angles(np.radians(PATH_DEG)), robot.setup.targets[0])
    weight = np.zeros((len(PATH_DEG), 6))
    before = aligned(truth.places(chain, np.radians(PATH_DEG), weight), wanted)
    after = aligned(truth.places(chain, corrected.found.joints, weight), wanted)
    assert np.sqrt(np.mean(before**2)) > 3e-4
    assert np.all(after < corrected.found.residual_95)
    assert corrected.found.residual_95.max() < 1.5e-4
    taught = compensate_campaign(folder, replace(wish, sag=False))
    assert taught.wanted == "unloaded robot"
    assert np.abs(taught.found.joints - np.radians(PATH_DEG)).max() < 1e-9
    loaded = compensate_campaign(folder, replace(wish, forces=Forces("0,0,-300")))
    assert any("act at the origin of the flange" in warning for warning in loaded.warnings) is bool(which)


def test_lines_out_of_reach_are_one_line_of_the_answer(measured: tuple[Path, Path, Truth], tmp_path: Path) -> None:
    """Along the stretched arm nothing can be corrected: the rows are named together, with what would remain."""
    folder = measured[0]
    stretched = np.degrees(np.arctan2(0.15, 0.88))
    angles = ["10,-40,60,0,50,0", f"0,-40,{stretched},0,0,0", f"1,-40,{stretched},0,0,0", "10,-40,60,0,50,0"]
    (tmp_path / "path.csv").write_text("\n".join(["A1,A2,A3,A4,A5,A6", *angles]) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        compensate_campaign(folder, CompensateRequest(tmp_path / "path.csv", Forces("0,0,0")))
    (fault,) = refused.value.faults
    assert (fault.code, fault.place) == (FaultCode.POSE_UNREACHABLE, "lines 3 to 4")
    assert "singular" in fault.reason
