"""One robot written as DH rows, as modified DH rows and as URDF: the same answers, and pinocchio's for the URDF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.mujoco_robot import MujocoRobot
from tests.laboratory.pinocchio_robot import gravity_torques, pin
from tests.laboratory.robots import SIX_AXES, SIX_STIFFNESS, force_sensor_setup, shifted, six_axes, six_axis_joints

EXACT = 1e-12
FLANGE = {"xyz_m": [0.01, 0.0, 0.14], "rpy_deg": [10.0, -20.0, 30.0]}


def robot_file(rows: list[dict[str, Any]], convention: str | None, **more: Any) -> RobotFile:
    document = {"schema": "stiffcal/robot/1", "joints": rows, "flange": FLANGE, **more}
    return RobotFile.model_validate(document | ({"convention": convention} if convention else {}))


def modified_dh_rows() -> list[dict[str, Any]]:
    return [
        {
            "name": f"A{k + 1}", "a_m": a, "alpha_deg": alpha, "d_m": d, "theta_deg": theta,
            "link": {"name": f"part{k + 1}", "mass_kg": mass, "com_m": list(com)},
        }
        for k, (a, alpha, d, theta, mass, com) in enumerate(SIX_AXES)
    ]  # fmt: skip


def dh_rows() -> list[dict[str, Any]]:
    """Move a and alpha one row up: Rz Tz of a row, then the next row's Tx Rx; com counts from before Tz."""
    rows = modified_dh_rows()
    for k, row in enumerate(rows):
        after = SIX_AXES[k + 1] if k < 5 else (0.0, 0.0)
        x, y, z = row["link"]["com_m"]
        row |= {"a_m": after[0], "alpha_deg": after[1]}
        row["link"] |= {"com_m": [x, y, z + row["d_m"]]}
    return rows


def write_urdf(folder: Path, axes: Floats | None = None) -> str:
    """Write the robot as URDF; theta goes into the joint's origin, com and masses into the links."""
    links, joints = ['<link name="base_link"/>'], []
    for k, (a, alpha, d, theta, mass, com) in enumerate(SIX_AXES):
        # fixed-axis rpy of Rx(alpha) Rz(theta) with alpha a multiple of 90 degrees
        roll, yaw = np.radians(alpha), np.radians(theta)
        rotation = _x(roll) @ _z(yaw)
        rpy = _rpy(rotation)
        lift = np.array([a, 0.0, 0.0]) + _x(roll) @ np.array([0.0, 0.0, d])
        axis = "0 0 1" if axes is None else " ".join(map(repr, axes[k].tolist()))
        joints.append(
            f'<joint name="A{k + 1}" type="revolute"><parent link="{"base_link" if k == 0 else f"part{k}"}"/>'
            f'<child link="part{k + 1}"/><origin xyz="{lift[0]} {lift[1]} {lift[2]}" rpy="{rpy[0]} {rpy[1]} {rpy[2]}"/>'
            f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )
        links.append(
            f'<link name="part{k + 1}"><inertial><origin xyz="{com[0]} {com[1]} {com[2]}"/><mass value="{mass}"/>'
            '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    text = f'<robot name="medium">{"".join(links)}{"".join(joints)}</robot>'
    (folder / "robot.urdf").write_text(text, encoding="utf-8")
    return text


def _x(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def _z(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _rpy(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch, yaw (fixed x, y, z); pinocchio's own formula."""
    roll, pitch, yaw = pin.rpy.matrixToRpy(rotation)
    return float(roll), float(pitch), float(yaw)


@pytest.fixture
def three(tmp_path: Path) -> list[Chain]:
    write_urdf(tmp_path)
    return [
        chain_of(robot_file(modified_dh_rows(), "modified-dh"), tmp_path),
        chain_of(robot_file(dh_rows(), "dh"), tmp_path),
        chain_of(robot_file([], None, urdf="robot.urdf"), tmp_path),
    ]


def test_modified_dh_by_hand(three: list[Chain]) -> None:
    """Craig's rows multiplied out one elementary transform after another."""
    logged = six_axis_joints(np.random.default_rng(21), 5)
    for q in logged:
        place = np.eye(4)
        for (a, alpha, d, theta, _, _), angle in zip(SIX_AXES, q, strict=True):
            for step in (
                shifted(a, 0, 0),
                _four(_x(np.radians(alpha))),
                _four(_z(angle + np.radians(theta))),
                shifted(0, 0, d),
            ):
                place = place @ step  # fmt: skip
        at, _ = attached_poses(three[0], three[0].model_angles(q[None]), Attachment(6, np.eye(4)))
        np.testing.assert_allclose(at[0], place[:3, 3], atol=EXACT)


def test_dh_by_hand() -> None:
    """Denavit-Hartenberg rows that no modified row is like: a random robot."""
    rng = np.random.default_rng(22)
    numbers = rng.uniform(-1, 1, (6, 4)) * [0.5, 180.0, 0.5, 180.0]
    rows = [
        {"name": f"A{k}", "a_m": a, "alpha_deg": al, "d_m": d, "theta_deg": th}
        for k, (a, al, d, th) in enumerate(numbers.tolist())
    ]
    chain = chain_of(robot_file(rows, "dh"), Path())
    q = rng.uniform(-3, 3, 6)
    place, axes = np.eye(4), []
    for (a, alpha, d, theta), angle in zip(numbers, q, strict=True):
        axes.append((place[:3, 2], place[:3, 3]))
        place = place @ _four(_z(angle + np.radians(theta))) @ shifted(a, 0.0, d) @ _four(_x(np.radians(alpha)))
    roll, pitch, yaw = np.radians(FLANGE["rpy_deg"])
    flange = _four(pin.rpy.rpyToMatrix(float(roll), float(pitch), float(yaw)))
    flange[:3, 3] = FLANGE["xyz_m"]
    place = place @ flange
    angles = chain.model_angles(q[None])
    at, turn = attached_poses(chain, angles, Attachment(7, np.eye(4)))
    np.testing.assert_allclose(at[0], place[:3, 3], atol=EXACT)
    np.testing.assert_allclose(turn[0], place[:3, :3], atol=EXACT)
    expected = np.stack([np.concatenate([np.cross(z, place[:3, 3] - o), z]) for z, o in axes], axis=1)
    np.testing.assert_allclose(jacobians(chain, angles, Attachment(7, np.eye(4)))[0], expected, atol=EXACT)


def test_same_balance_in_all_three(three: list[Chain]) -> None:
    """Deflections under load and weight, DH, modified DH, URDF: alike to rounding; and MuJoCo's."""
    rng = np.random.default_rng(23)
    logged, wrench = six_axis_joints(rng, 40), rng.normal(size=(40, 6)) * np.repeat([400.0, 60.0], 3)
    effect = find_effects()["joint-compliance"]
    found = []
    for chain in three:
        placed = tuple(
            PlacedEffect(effect, Place("joints", (k,)), {"c": float(1.0 / SIX_STIFFNESS[k - 1])}) for k in range(1, 7)
        )
        setup = force_sensor_setup(chain, 9.0, (0.0, 0.02, 0.1))
        assert chain.masses_known
        angles = chain.model_angles(logged)
        found.append(solve_balance(CompliantRobot(chain, placed), angles, wrench, setup))
        outside = MujocoRobot(chain, SIX_STIFFNESS, setup).settle(angles, wrench)
        np.testing.assert_allclose(found[-1].target_position, outside.position, rtol=0, atol=1e-10)
    for other in found[1:]:
        np.testing.assert_allclose(other.target_position, found[0].target_position, rtol=0, atol=1e-11)
        np.testing.assert_allclose(other.displacement, found[0].displacement, rtol=0, atol=1e-11)


def test_urdf_against_pinocchios_own_reader(tmp_path: Path) -> None:
    """Axes in any direction, length other than one included; places of the tip, Jacobians and weights."""
    rng = np.random.default_rng(24)
    axes = rng.normal(size=(6, 3))
    text = write_urdf(tmp_path, axes)
    chain = chain_of(robot_file([], None, urdf="robot.urdf"), tmp_path)
    model = pin.buildModelFromXML(text)
    tip = model.getFrameId("part6")
    unturned = _four(pin.rpy.rpyToMatrix(*np.radians(FLANGE["rpy_deg"]).tolist()).T)
    back = shifted(*(-np.array(FLANGE["xyz_m"])))
    angles = rng.uniform(-3, 3, (10, 6))
    at_tip = Attachment(7, unturned @ back)
    places, turns = attached_poses(chain, angles, at_tip)
    ours = jacobians(chain, angles, at_tip)
    for i, q in enumerate(angles):
        data = model.createData()
        theirs = pin.computeFrameJacobian(model, data, q, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        pin.framesForwardKinematics(model, data, q)
        np.testing.assert_allclose(places[i], data.oMf[tip].translation, atol=EXACT)
        np.testing.assert_allclose(turns[i], data.oMf[tip].rotation, atol=EXACT)
        np.testing.assert_allclose(ours[i], theirs, atol=EXACT)
        weights = np.zeros(6)
        for k in range(6):
            points = Attachment(k + 1, shifted(*chain.link_com[k]))
            lever = jacobians(chain, angles[i : i + 1], points)[0, :3]
            weights += lever.T @ (chain.link_mass[k] * chain.gravity)
        np.testing.assert_allclose(-weights, gravity_torques(model, q), atol=1e-9)


def test_medium_robot_as_numbers_is_the_one_from_rows(tmp_path: Path) -> None:
    """The chain that the other tests build without any reader is what the robot file gives."""
    chain = chain_of(robot_file(modified_dh_rows(), "modified-dh", flange={"xyz_m": [0.0, 0.0, 0.14]}), tmp_path)
    np.testing.assert_allclose(chain.fixed, six_axes().fixed, atol=1e-15)
    np.testing.assert_allclose(chain.flange, six_axes().flange, atol=1e-15)
    np.testing.assert_allclose(chain.link_com, six_axes().link_com, atol=1e-15)


def _four(rotation: Floats) -> Floats:
    place = np.eye(4)
    place[:3, :3] = rotation
    return place
