"""`map`: what is reached, what is found there, and what is refused."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.map import MapRequest, map_campaign
from stiffcal.commands.predict import predict_campaign
from stiffcal.compensation.inverse import joints_along_path
from stiffcal.compensation.targets import PoseGoal
from stiffcal.compensation.workspace import longest_reach
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.report.figures.workspace import _title
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from tests.commands.test_predict import poses_file
from tests.laboratory.robots import force_sensor_setup, seven_axes
from tests.laboratory.small_campaign import POSES_DEG

NAMES = ("A1", "A2", "A3", "A4", "A5", "A6")
POSE = ",".join(str(angle) for angle in POSES_DEG[0])


def test_every_point_holds_what_predict_says_there(campaign: Path) -> None:
    table = campaign / "map.csv"
    request = MapRequest("0,50,-200", stiffness="z", plane="xz", at=-0.3, points=6, pose=POSE)
    result = map_campaign(campaign, request, table=table)
    slices, rows, columns = result.shape
    assert (slices, max(rows, columns)) == (1, 6)
    worst = result.worst
    assert worst is not None
    assert worst.status == "reached"
    assert worst.deflection is not None
    largest = max(np.linalg.norm(p.deflection[:3]) for p in result.points if p.deflection is not None)
    assert np.linalg.norm(worst.deflection[:3]) == pytest.approx(largest, rel=1e-12)
    reached = [point for point in result.points if point.status == "reached"]
    assert len(reached) == result.reached > 5
    robot = fitted_robot(load_campaign(campaign, check_files=False), RunContext())
    chain, target = robot.campaign.chain, robot.setup.targets[0]
    kept = attached_poses(chain, chain.model_angles(np.radians([POSES_DEG[0]])), target)[1][0]
    joints = np.array([point.joints for point in reached])
    place, turned = attached_poses(chain, chain.model_angles(joints), target)
    assert np.allclose(place, [point.position for point in reached], atol=1e-6)
    assert np.allclose(turned, kept, atol=1e-6)
    some = [",".join(f"{angle:.12g}" for angle in np.degrees(one)) + ",0,50,-200,0,0,0" for one in joints[:3]]
    said = predict_campaign(campaign, poses=poses_file(campaign, some)).states
    for state, point in zip(said, reached, strict=False):
        assert point.deflection is not None
        assert point.std is not None
        assert np.allclose(state.deflection, point.deflection, atol=1e-9)
        assert 1.0 / state.cartesian_compliance[2][2] == pytest.approx(point.stiffness, rel=1e-6)
        assert np.sqrt(np.trace(np.array(state.covariance)[:3, :3])) == pytest.approx(point.std[0], rel=1e-3)
    with table.open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(result.points)
    assert result.position_error is not None
    assert result.position_error[1] == pytest.approx(
        1e-3 * max(float(line["position error [mm]"]) for line in lines if line["status"] == "reached")
    )


def test_reach_and_limits(campaign: Path) -> None:
    robot = campaign / "robot.toml"
    limits = {"A1": "[-60, 60]", "A2": "[-150, -20]", "A3": "[-60, 80]"}
    text = robot.read_text()
    for name, ends in limits.items():
        text = text.replace(f'name = "{name}"\n', f'name = "{name}"\nlimits_deg = {ends}\n')
    robot.write_text(text)
    result = map_campaign(campaign, MapRequest("0,0,-200", plane="xy", at=0.9, points=7), RunContext())
    inside = fitted_robot(load_campaign(campaign, check_files=False), RunContext())
    chain, target = inside.campaign.chain, inside.setup.targets[0]
    assert result.beyond_limits > 0
    for point in result.points:
        if point.status == "reached":
            joints = np.array(point.joints)
            assert np.all((joints >= chain.limits[:, 0]) & (joints <= chain.limits[:, 1]))
            assert point.limit_margin is not None
            assert point.limit_margin >= 0.0
        if np.linalg.norm(np.array(point.position) - [0.0, 0.0, 0.68]) > longest_reach(chain, target):
            assert point.status == "out of reach"


@pytest.mark.parametrize(
    ("request_", "panels", "load"),
    [
        (MapRequest("0,0,-1962", stiffness="0,1,1", points=4), 3, "(0, 0, −1962) N"),
        (MapRequest(mass=20.0, slices=2, points=4), 2, "(0, 0, −196."),
    ],
)
def test_pictures_of_a_plane_and_of_a_volume(campaign: Path, request_: MapRequest, panels: int, load: str) -> None:
    picture = campaign / "map.svg"
    result = map_campaign(campaign, request_, picture=picture)
    assert picture.stat().st_size > 5000
    assert len(result.levels) == request_.slices
    assert load in _title(result)
    # a label under each colour bar
    assert picture.read_text().count("<image") >= panels


def test_a_hung_mass_pulls_along_gravity(campaign: Path) -> None:
    result = map_campaign(campaign, MapRequest(mass=0.153, points=3))
    assert result.wrench == pytest.approx([0.0, 0.0, -0.153 * 9.81, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (MapRequest(), "nothing to map"),
        (MapRequest("1,2"), "is not a wrench"),
        (MapRequest("1,2,3", mass=1.0), "--load is already given"),
        (MapRequest(mass=-1.0), "is no mass"),
        (MapRequest("1,2,3", stiffness="0,0,0"), "is not a direction"),
        (MapRequest("1,2,3", plane="zz"), "no plane zz"),
        (MapRequest("1,2,3", points=1), "1 points"),
        (MapRequest("1,2,3", pose="1,2"), "2 angles, the robot has 6 joints"),
        (MapRequest("0,0,-9e6", points=4), "no equilibrium"),
    ],
)
def test_faulty_requests(campaign: Path, request_: MapRequest, message: str) -> None:
    with pytest.raises(InputError, match=message):
        map_campaign(campaign, request_)


def test_a_target_on_the_only_axis_has_no_map(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # one joint, and the target on its axis: it stands at one place, but for rounding
    box = np.full((3, 2), 0.4) + np.array([0.0, 1e-16])
    monkeypatch.setattr("stiffcal.compensation.workspace.reached_box", lambda *_: box)
    with pytest.raises(InputError, match="do not move the target in the plane xz") as error:
        map_campaign(campaign, MapRequest("0,0,-10"))
    assert error.value.faults[0].code is FaultCode.POSE_UNREACHABLE


def test_faulty_files(campaign: Path) -> None:
    for picture, table in ((Path("map.txt"), None), (None, Path("map.txt")), (campaign / "no" / "map.svg", None)):
        with pytest.raises(InputError, match=r"a name that ends in \.txt does not fit|its folder does not exist"):
            map_campaign(campaign, MapRequest("0,0,-100"), picture=picture, table=table)


def test_seven_joints_follow_a_path_of_poses() -> None:
    rng = np.random.default_rng(3)
    chain = replace(seven_axes(), limits=np.tile([-2.5, 2.5], (7, 1)))
    target = force_sensor_setup(chain).targets[0]
    start = rng.uniform(-1.0, 1.0, 7)
    joints = start + np.linspace(0.0, 0.3, 6)[:, None] * rng.uniform(-1.0, 1.0, 7)
    place, turned = attached_poses(chain, joints, target)
    for near in (start, None):
        found, reached = joints_along_path(chain, target, PoseGoal(place, turned), near)
        assert reached.all()
        assert np.allclose(attached_poses(chain, found, target)[0], place, atol=1e-8)
        assert np.abs(np.diff(found, axis=0)).max() < 0.2  # no jump to another posture
