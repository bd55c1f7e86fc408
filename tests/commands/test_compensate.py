"""`compensate`: what is left on the true robot, what is printed of it, and what is refused."""

from __future__ import annotations

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.compensate import compensate_campaign
from stiffcal.compensation.corrected_path import CompensateRequest
from stiffcal.compensation.fitted_robot import FittedRobot, _cautions
from stiffcal.compensation.path import read_path
from stiffcal.compensation.path_forces import Forces
from stiffcal.compensation.tool_weight import weight_on_sensor
from stiffcal.documents import Document, document_of
from stiffcal.errors import InputError
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.quaternions import quaternion_from_rotation
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from tests.laboratory.fits import fit_of, parameter
from tests.laboratory.small_campaign import POSES_DEG, STIFFNESS, write_small_campaign

NAMES = "A1,A2,A3,A4,A5,A6"
# what gives on a real robot next to its drives: bearings, foundation, and a drive that is softer one way
OTHERS = """
[[effects]]
type = "bearing-tilt"
joints = [1, 2, 3]
[effects.parameters]
"bearing-tilt.j1.x" = { value = 3e-7 }
"bearing-tilt.j1.y" = { value = 3e-7 }
"bearing-tilt.j2.x" = { value = 4e-7 }
"bearing-tilt.j2.y" = { value = 4e-7 }
"bearing-tilt.j3.x" = { value = 5e-7 }
"bearing-tilt.j3.y" = { value = 5e-7 }

[[effects]]
type = "asymmetric-stiffness"
joints = [2]
[effects.parameters]
"asymmetric-stiffness.j2.c" = { value = 4e-7 }
"""


def true_robot(folder: Path, others: str = "") -> Path:
    """Write a folder whose model file holds the robot as it really is, and that has no logs."""
    campaign = Path(shutil.copytree(folder, folder.with_name("true-" + folder.name), symlinks=True))
    for gone in ("raw", "store"):
        shutil.rmtree(campaign / gone, ignore_errors=True)
    values = "\n".join(f'"joint-compliance.j{k + 1}.c" = {{ value = {1 / c!r} }}' for k, c in enumerate(STIFFNESS))
    drives = (campaign / "model.toml").read_text().split("[[effects]]\n")[1]
    head = 'schema = "stiffcal/model/1"\n'
    (campaign / "model.toml").write_text(f"{head}[[effects]]\n{drives}[effects.parameters]\n{values}\n{others}")
    return campaign


def path_file(folder: Path, header: str = NAMES, rows: int = 24, more: str = "") -> Path:
    """Write a path that goes from the first pose of the campaign to the second."""
    share = np.linspace(0.1, 0.9, rows)[:, None]
    joints = (1.0 - share) * np.array(POSES_DEG[0]) + share * np.array(POSES_DEG[1])
    file = folder / "path.csv"
    lines = [",".join(f"{angle:.9g}" for angle in row) + more for row in joints]
    file.write_text("\n".join([header, *lines]) + "\n")
    return file


def valued(folder: Path) -> FittedRobot:
    return fitted_robot(load_campaign(folder, check_files=False), RunContext())


def lengths(document: Document, key: str) -> Floats:
    return np.asarray(np.linalg.norm(np.array([row[key][:3] for row in document["rows"]]), axis=1))


def test_the_right_model_takes_more_than_95_per_cent_and_says_what_is_left(campaign: Path) -> None:
    wish = CompensateRequest(path_file(campaign), Forces("120,200,-300,10,-20,5"), judge=true_robot(campaign))
    document = document_of(compensate_campaign(campaign, wish, output=campaign / "out.csv"))
    assert lengths(document, "error_after").max() < 1e-6
    assert lengths(document, "error_before").max() > 1e-3
    judged = document["judged"]
    assert judged["gone"] > 0.95
    with (campaign / "out.csv").open() as file:
        rows = list(csv.DictReader(file))
    left = np.array([float(row["judged after [mm]"]) for row in rows])
    printed = np.array([float(row["residual, 95 % [mm]"]) for row in rows])
    assert np.all(left < printed)
    assert printed.max() < 0.05 * 1e3 * lengths(document, "error_before").min()
    assert document["residual_95"] == pytest.approx(1e-3 * printed.max())
    assert not any("missing" in text or "do not identify" in text for text in document["warnings"])


def test_joint_compliance_alone_takes_60_per_cent_on_a_robot_that_has_more(tmp_path: Path) -> None:
    """Wang, Zhang and Fuhlbrigge 2009: with a model of the drives alone more than 60 % of the deflection goes."""
    folder = write_small_campaign(tmp_path / "small", hidden=OTHERS)
    wish = CompensateRequest(path_file(folder), Forces("120,200,-300"), judge=true_robot(folder, OTHERS))
    document = document_of(compensate_campaign(folder, wish))
    assert 0.60 < document["judged"]["gone"] < 0.98
    # what is left is the bearings', which no uncertainty of the drives holds
    assert any("something is missing in it" in text for text in document["warnings"])


def test_what_the_data_do_not_show_is_said() -> None:
    names = ["joint-compliance.j1.c", "joint-compliance.j2.c"]
    fit = fit_of(
        parameters=[document_of(parameter(names[0], None)), document_of(parameter(names[1], 1e-6))],
        not_identifiable=[{"parameters": names, "known": None, "reason": ""}],
        rms={"translation": 2e-5, "rotation": None},
        noise={"translation": None, "rotation": None},
    )
    (said,) = _cautions(fit, set(names))
    assert "do not identify joint-compliance.j1.c: taken as rigid" in said
    assert not list(_cautions(fit, set()))


def test_poses_in_space_are_reached_sag_and_all(campaign: Path) -> None:
    robot = valued(campaign)
    chain, target = robot.campaign.chain, robot.setup.targets[0]
    joints = np.radians([POSES_DEG[0]]) + np.linspace(0.0, 0.1, 5)[:, None] * np.array([1.0, 0.5, -0.5, 1.0, 0.0, 0.0])
    position, rotation = attached_poses(chain, chain.model_angles(joints), target)
    quaternion = quaternion_from_rotation(rotation)
    lines = [",".join(f"{x:.12g}" for x in (*(1e3 * p), *q)) for p, q in zip(position, quaternion, strict=True)]
    file = campaign / "poses.csv"
    file.write_text("\n".join(["X,Y,Z,qw,qx,qy,qz", *lines]) + "\n")
    start = ",".join(str(angle) for angle in POSES_DEG[0])
    document = document_of(compensate_campaign(campaign, CompensateRequest(file, Forces("0,0,-300"), start=start)))
    assert np.allclose([row["joints"] for row in document["rows"]], joints, atol=1e-7)
    assert lengths(document, "error_after").max() < 1e-6
    # unlike a path of joint angles, the sag under weight is taken out too
    deflection = lengths(document, "deflection")
    assert np.all(lengths(document, "error_before") > deflection + 2e-4)
    without = document_of(
        compensate_campaign(campaign, CompensateRequest(file, Forces("0,0,-300"), start=start, sag=False))
    )
    assert np.allclose(lengths(without, "error_before"), deflection)


def test_forces_of_segments(campaign: Path) -> None:
    file = path_file(campaign, NAMES + ",segment", 4)
    text = file.read_text().splitlines()
    file.write_text("\n".join([text[0], *(line + f",{name}" for line, name in zip(text[1:], "abba", strict=True))]))
    forces = campaign / "segments.csv"
    forces.write_text("segment,Fx [kN],Fz\na,0.1,0\nb,0,-200\n")
    document = document_of(compensate_campaign(campaign, CompensateRequest(file, Forces(segments=forces))))
    assert [row["wrench"][0] for row in document["rows"]] == [100.0, 0.0, 0.0, 100.0]
    assert [row["wrench"][2] for row in document["rows"]] == [0.0, -200.0, -200.0, 0.0]
    forces.write_text("segment,Fx\na,100\n")
    with pytest.raises(InputError, match="line 3: no force for the segment b"):
        compensate_campaign(campaign, CompensateRequest(file, Forces(segments=forces)))


def test_a_sensors_log_is_filtered_and_weighed(campaign: Path) -> None:
    """A log in axes that turn with the flange, its noise filtered, the tool's weight taken out, the tare with it."""
    robot = valued(campaign)
    chain = robot.campaign.chain
    file = path_file(campaign, NAMES + ",t", 40)
    text = file.read_text().splitlines()
    times = np.linspace(1.0, 5.0, 40)
    lines = [line + f",{t:.6f}" for line, t in zip(text[1:], times, strict=True)]
    file.write_text("\n".join([text[0], *lines]))
    joints = np.radians([[float(word) for word in line.split(",")[:6]] for line in text[1:]])
    moments = np.arange(0.9, 5.1, 0.002)
    angles = chain.model_angles(np.stack([np.interp(moments, times, joints[:, k]) for k in range(6)], axis=1))
    sensor = Attachment(7, robot.setup.wrench_point.transform)
    com = np.array([0.01, 0.0, 0.1])
    weight = weight_on_sensor(chain, angles, sensor, 6.0, com)
    rng = np.random.default_rng(2)
    noise = 4.0 * rng.standard_normal((len(moments), 6))
    process = np.zeros((len(moments), 6))
    process[:, 2] = -250.0
    reading = -(process + weight - weight[0] + noise)  # what the robot does to its surroundings
    log = campaign / "log.csv"
    rows = [",".join(f"{x:.6f}" for x in (t, *row)) for t, row in zip(moments, reading, strict=True)]
    log.write_text("\n".join(["t,Fx,Fy,Fz,Tx,Ty,Tz", *rows]))
    forces = Forces(log=log, frame="load_point", acts_on="environment", filter_hz=3.0, tool="6,0.01,0,0.1", zeroed=True)
    document = document_of(compensate_campaign(campaign, CompensateRequest(file, forces)))
    found = np.array([row["wrench"] for row in document["rows"]])
    # 4 N of noise at 500 Hz leaves about 4 √(3·1.1·2/500) = 0.5 N
    assert np.abs(found[:, :3] - [0.0, 0.0, -250.0]).max() < 2.0
    raw = document_of(
        compensate_campaign(campaign, CompensateRequest(file, replace(forces, tool=None, filter_hz=None)))
    )
    rough = np.array([row["wrench"] for row in raw["rows"]])
    assert np.abs(rough[:, :3] - [0.0, 0.0, -250.0]).max() > 8.0


def test_what_is_written_is_a_path_again(campaign: Path) -> None:
    output = campaign / "out.csv"
    compensate_campaign(campaign, CompensateRequest(path_file(campaign, rows=3), Forces("0,0,-300")), output=output)
    assert output.read_text().startswith('"A1 [deg]"') or output.read_text().startswith("A1 [deg]")
    again = document_of(compensate_campaign(campaign, CompensateRequest(output)))
    assert [row["wrench"][2] for row in again["rows"]] == [-300.0] * 3


def test_no_rounding_of_the_solver_is_written_as_an_angle(campaign: Path) -> None:
    """In the plane of the arm a weight turns no vertical axis: its angle stays, and is no 1e-12 degrees."""
    path, output = campaign / "plane.csv", campaign / "out.csv"
    path.write_text(f"{NAMES}\n0,-60,80,0,-20,0\n0,-50,70,0,-30,0\n")
    compensate_campaign(campaign, CompensateRequest(path, Forces("0,0,-300")), output=output)
    rows = list(csv.DictReader(output.read_text().splitlines()))
    angles = np.array([[float(cell) for name, cell in row.items() if name.endswith("[deg]")] for row in rows])
    assert angles.shape == (2, 6)
    assert ((angles == 0.0) | (np.abs(angles) >= 1e-9)).all(), angles


@pytest.mark.parametrize("ending", ["svg", "pdf"])
def test_the_picture(campaign: Path, ending: str) -> None:
    picture = campaign / f"error.{ending}"
    wish = CompensateRequest(path_file(campaign, rows=6), Forces("0,100,-300"), normal="0,0,1")
    assert document_of(compensate_campaign(campaign, wish, picture=picture))["picture"] == str(picture)
    assert picture.stat().st_size > 3000


def test_a_circles_error_is_shown_along_its_radius(campaign: Path) -> None:
    from stiffcal.compensation.corrected_path import _direction

    turn = np.linspace(0.0, 2.0 * np.pi, 20)
    place = np.array([1.2, 0.3, 0.9]) + 0.035 * np.stack([np.cos(turn), np.zeros(20), np.sin(turn)], axis=1)
    direction, words = _direction("radial", place[:13])
    assert direction is not None
    assert np.allclose(direction, (place[:13] - [1.2, 0.3, 0.9]) / 0.035)
    assert "radial" in words
    with pytest.raises(InputError, match="not a circle"):
        _direction("radial", np.linspace([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], 8))


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        (Forces(), "no forces are given"),
        (Forces("1,2"), "is not a wrench"),
        (Forces("1,2,3", segments=Path("x")), "forces are given more than once"),
        (Forces("1,2,x"), "contains something that is not a number"),
        (Forces("1,2,3", filter_hz=5.0), "apply to logged forces only"),
        (Forces("1,2,3", frame="nowhere"), "unknown frame nowhere"),
        (Forces(log=Path("nowhere.csv")), "no such file"),
        (Forces("0,0,-9e6"), "no equilibrium"),
    ],
)
def test_faulty_forces(campaign: Path, forces: Forces, message: str) -> None:
    with pytest.raises(InputError, match=message):
        compensate_campaign(campaign, CompensateRequest(path_file(campaign, rows=3), forces))


def test_joints_beyond_their_limits_and_poses_out_of_reach(campaign: Path) -> None:
    robot = campaign / "robot.toml"
    robot.write_text(robot.read_text().replace('name = "A1"\n', 'name = "A1"\nlimits_deg = [-90, 5]\n'))
    with pytest.raises(InputError, match=r"path.csv: line 31: A1 = 6° lies beyond its limits; .* -90° … 5°"):
        compensate_campaign(campaign, CompensateRequest(path_file(campaign, rows=30), Forces("0,0,-300")))
    far = campaign / "far.csv"
    far.write_text("X,Y,Z\n9000,0,0\n1400,0,900\n")
    with pytest.raises(InputError, match="far.csv: line 2: the robot does not reach this pose"):
        compensate_campaign(campaign, CompensateRequest(far, Forces("0,0,-300")))


def test_a_correction_that_a_limit_stops_is_said(campaign: Path) -> None:
    wish = CompensateRequest(path_file(campaign, rows=3), Forces("0,300,0"))
    free = document_of(compensate_campaign(campaign, wish))["rows"][0]
    moved = np.degrees(np.array(free["corrected"]) - np.array(free["joints"]))
    end = float(np.degrees(free["joints"][0]) + 0.3 * moved[0])
    limits = [-170.0, end] if moved[0] > 0.0 else [end, 170.0]
    robot = campaign / "robot.toml"
    robot.write_text(robot.read_text().replace('name = "A1"\n', f'name = "A1"\nlimits_deg = {limits}\n'))
    warnings = document_of(compensate_campaign(campaign, wish))["warnings"]
    assert any("the position is reached" in text and "A1 at its limit" in text for text in warnings)


def test_units_that_were_forgotten_are_suspected(campaign: Path) -> None:
    forces = Forces("0,0,-300")
    file = campaign / "radians.csv"
    file.write_text(f"{NAMES}\n0.1,0.2,-0.1,0.3,0.5,0.1\n")
    document = document_of(compensate_campaign(campaign, CompensateRequest(file, forces)))
    assert any('write the unit after the names, "A1 [rad]"' in text for text in document["warnings"])
    file.write_text(",".join(f"{name} [rad]" for name in NAMES.split(",")) + "\n0.1,0.2,-0.1,0.3,0.5,0.1\n")
    assert not any(
        "radians" in text
        for text in document_of(compensate_campaign(campaign, CompensateRequest(file, forces)))["warnings"]
    )
    file.write_text("X,Y,Z\n1.4,0,0.9\n")
    document = document_of(compensate_campaign(campaign, CompensateRequest(file, forces)))
    assert any("are they in metres?" in text for text in document["warnings"])


def test_a_refusal_names_the_unit_that_may_be_its_cause(campaign: Path) -> None:
    robot = campaign / "robot.toml"
    robot.write_text(robot.read_text().replace('name = "A2"\n', 'name = "A2"\nlimits_deg = [-120, -30]\n'))
    fitted, file = valued(campaign), campaign / "other-units.csv"
    for text, mends in (
        (f"{NAMES}\n0.1,-1.2,-0.1,0.3,0.5,0.1\n", ["A1 [rad]"]),
        ("X,Y,Z,roll,pitch,yaw\n1.4,0,0.9,0,1.57,0\n", ["X [m]", "roll [rad]"]),
    ):
        file.write_text(text)
        with pytest.raises(InputError) as caught:
            read_path(fitted, fitted.aimed_at(None)[0], file, Forces("0,0,-300"), None)
        assert all(mend in caught.value.faults[0].mend for mend in mends)


def test_faulty_wishes(campaign: Path) -> None:
    file = path_file(campaign, rows=3)
    forces = Forces("0,0,-300")
    for wish, message in (
        (CompensateRequest(file, forces, target="nowhere"), "unknown frame nowhere"),
        (CompensateRequest(file, forces, target="base"), "base is fixed to the ground"),
        (CompensateRequest(campaign / "nothing.csv", forces), "no such file"),
    ):
        with pytest.raises(InputError, match=message):
            compensate_campaign(campaign, wish)
    with pytest.raises(InputError, match=r"a name that ends in \.bmp does not fit"):
        compensate_campaign(campaign, CompensateRequest(file, forces), picture=Path("x.bmp"))
    wish = CompensateRequest(file, forces, normal="1,2")
    with pytest.raises(InputError, match="is not a direction"):
        compensate_campaign(campaign, wish, picture=campaign / "x.svg")
    single = CompensateRequest(path_file(campaign, rows=1), forces)
    with pytest.raises(InputError, match="a path with one pose cannot be drawn"):
        compensate_campaign(campaign, single, picture=campaign / "x.svg")
