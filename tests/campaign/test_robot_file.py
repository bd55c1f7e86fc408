"""Robot files: DH, modified DH and URDF give the same bodies; pinocchio agrees on the URDF."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.robot.urdf.chain import read_urdf
from stiffcal.errors import InputError
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_rpy
from tests.laboratory.campaign_folders import DATA

# a robot with no two conventions' origins alike: row k = (a, alpha°, d, theta°) of the *standard* convention
ROWS = [
    (0.25, 90.0, 0.6, 10.0),
    (0.9, 5.0, 0.04, -80.0),
    (0.15, 90.0, -0.02, 0.0),
    (0.01, -90.0, 0.88, 0.0),
    (0.0, 85.0, 0.03, 20.0),
    (0.02, 3.0, 0.14, 0.0),
]
BEARINGS = [0.10, -0.05, 0.02, 0.30, 0.01, 0.07]  # of the modified-dh file, along each axis


def robot(document: dict[str, Any]) -> RobotFile:
    return RobotFile.model_validate({"schema": "stiffcal/robot/1", **document})


def dh_chain(bearings: list[float] | None = None) -> Chain:
    joints = [
        {"name": f"A{k + 1}", "a_m": a, "alpha_deg": alpha, "d_m": d, "theta_deg": theta}
        for k, (a, alpha, d, theta) in enumerate(ROWS)
    ]
    for joint, bearing in zip(joints, bearings or [0.0] * 6, strict=True):
        joint["bearing_m"] = bearing
    return chain_of(robot({"convention": "dh", "joints": joints}), Path())


def modified_chain(bearings: list[float] | None = None) -> Chain:
    """The same robot: Craig's row k takes a and alpha of the standard row k - 1; the last pair goes to the flange."""
    before = [(0.0, 0.0), *((a, alpha) for a, alpha, _, _ in ROWS[:-1])]
    joints = [
        {"name": f"A{k + 1}", "a_m": a, "alpha_deg": alpha, "d_m": ROWS[k][2], "theta_deg": ROWS[k][3]}
        for k, (a, alpha) in enumerate(before)
    ]
    for joint, bearing in zip(joints, bearings or [0.0] * 6, strict=True):
        joint["bearing_m"] = bearing
    flange = {"xyz_m": [ROWS[-1][0], 0.0, 0.0], "rpy_deg": [ROWS[-1][1], 0.0, 0.0]}
    return chain_of(robot({"convention": "modified-dh", "joints": joints, "flange": flange}), Path())


def urdf_chain(folder: Path, bearings: list[float] | None = None) -> Chain:
    """The same robot as a URDF: every joint turns about its own z, then about odd axes through extra turns."""
    text = ['<robot name="r"><link name="base"/>']
    odd = [np.deg2rad([30.0 * k, -20.0 * k, 10.0 * k]) for k in range(7)]  # the URDF's frames are turned at will
    previous = np.eye(4)
    for k, (a, alpha, d, theta) in enumerate(ROWS):
        turn = rotation_from_rpy(odd[k + 1])
        place = np.eye(4)  # previous standard DH frame to joint k's axis, turned by theta
        place[:3, :3] = rotation_from_rpy(np.array([0.0, 0.0, np.deg2rad(theta)]))
        origin = previous @ place
        origin[:3, :3] = origin[:3, :3] @ turn
        axis = turn.T @ np.array([0.0, 0.0, 1.0])
        text.append(element(f"A{k + 1}", "revolute", "base" if k == 0 else f"l{k}", f"l{k + 1}", origin, axis))
        advance = np.eye(4)
        advance[:3, 3] = [0.0, 0.0, d]
        screw = np.eye(4)
        screw[:3, :3], screw[0, 3] = rotation_from_rpy(np.array([np.deg2rad(alpha), 0.0, 0.0])), a
        back = np.eye(4)
        back[:3, :3] = turn.T
        previous = back @ advance @ screw
    text.append(element("end", "fixed", "l6", "tool", previous, np.array([1.0, 0.0, 0.0])))
    text.append("</robot>")
    (folder / "r.urdf").write_text("\n".join(text))
    joints = [{"name": f"A{k + 1}", "bearing_m": bearing} for k, bearing in enumerate(bearings or [0.0] * 6)]
    return chain_of(robot({"urdf": "r.urdf", "joints": joints}), folder)


def element(name: str, kind: str, parent: str, child: str, origin: Floats, axis: Floats) -> str:
    r = origin[:3, :3]
    pitch = np.arcsin(-r[2, 0])
    roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    xyz = " ".join(f"{value:.17g}" for value in origin[:3, 3])
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{roll:.17g} {pitch:.17g} {yaw:.17g}"/>'
        f'<axis xyz="{axis[0]:.17g} {axis[1]:.17g} {axis[2]:.17g}"/></joint>'
    )


def frames(chain: Chain, logged: Floats) -> list[Floats]:
    """Joint frames and flange in base axes, written out plainly."""
    found, here = [], np.eye(4)
    for fixed, angle in zip(chain.fixed, chain.model_angles(logged[None])[0], strict=True):
        turn = np.eye(4)
        turn[:3, :3] = rotation_from_rpy(np.array([0.0, 0.0, angle]))
        here = here @ fixed @ turn
        found.append(here)
    return [*found, here @ chain.flange]


def test_dh_against_the_textbook_product() -> None:
    logged = np.array([0.3, -0.7, 0.5, 1.1, -0.9, 2.0])
    here = np.eye(4)
    for (a, alpha, d, theta), q in zip(ROWS, logged, strict=True):
        t, s = q + np.deg2rad(theta), np.deg2rad(alpha)
        here = here @ np.array(  # Siciliano et al. 2009, eq. 2.52
            [
                [np.cos(t), -np.sin(t) * np.cos(s), np.sin(t) * np.sin(s), a * np.cos(t)],
                [np.sin(t), np.cos(t) * np.cos(s), -np.cos(t) * np.sin(s), a * np.sin(t)],
                [0.0, np.sin(s), np.cos(s), d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    np.testing.assert_allclose(frames(dh_chain(), logged)[-1], here, atol=1e-14)


def test_modified_dh_against_the_textbook_product() -> None:
    chain = modified_chain()
    logged = np.array([0.3, -0.7, 0.5, 1.1, -0.9, 2.0])
    here = np.eye(4)
    before = [(0.0, 0.0), *((a, np.deg2rad(alpha)) for a, alpha, _, _ in ROWS[:-1])]
    for (a, s), (_, _, d, theta), q, found in zip(before, ROWS, logged, frames(chain, logged), strict=False):
        t = q + np.deg2rad(theta)
        here = here @ np.array(  # Craig, Introduction to Robotics, 3rd ed., eq. 3.6
            [
                [np.cos(t), -np.sin(t), 0.0, a],
                [np.sin(t) * np.cos(s), np.cos(t) * np.cos(s), -np.sin(s), -np.sin(s) * d],
                [np.sin(t) * np.sin(s), np.cos(t) * np.sin(s), np.cos(s), np.cos(s) * d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
        np.testing.assert_allclose(found, here, atol=1e-14)


def test_three_conventions_have_the_same_axes_and_flange(tmp_path: Path) -> None:
    logged = np.array([0.3, -0.7, 0.5, 1.1, -0.9, 2.0])
    one, two, three = (frames(chain, logged) for chain in (dh_chain(), modified_chain(), urdf_chain(tmp_path)))
    for a, b, c in zip(one, two, three, strict=True):
        np.testing.assert_allclose(a[:3, 2], b[:3, 2], atol=1e-12)
        np.testing.assert_allclose(a[:3, 2], c[:3, 2], atol=1e-12)
        for other in (b, c):  # the same line: origins differ along the axis only
            off = other[:3, 3] - a[:3, 3]
            np.testing.assert_allclose(np.cross(off, a[:3, 2]), 0.0, atol=1e-12)
    np.testing.assert_allclose(one[-1], two[-1], atol=1e-12)
    np.testing.assert_allclose(one[-1], three[-1], atol=1e-12)


def test_bearings_make_nodes_and_beams_the_same(tmp_path: Path) -> None:
    """DH's origin of joint k lies d_k before modified DH's on the same axis; `bearing_m` makes up for it."""
    shifted = [bearing + row[2] for bearing, row in zip(BEARINGS, ROWS, strict=True)]
    modified, standard = modified_chain(BEARINGS), dh_chain(shifted)
    urdf = urdf_chain(tmp_path, shifted)
    logged = np.zeros(6)
    for name in ("swing", "arm"):
        places = []
        for chain in (modified, standard, urdf):
            beam = chain.beams[name]
            places.append(frames(chain, logged)[beam.joint - 1] @ beam.end)
            assert beam.length == pytest.approx(modified.beams[name].length, rel=1e-12)
        np.testing.assert_allclose(places[1], places[0], atol=1e-12)
        np.testing.assert_allclose(places[2], places[0], atol=1e-12)


def test_beam_axes() -> None:
    """x1 along, x3 the inboard axis made perpendicular, x2 = x3 × x1; parallel: the outboard axis."""
    chain = modified_chain()
    beam = chain.beams["arm"]
    x1, x2, x3 = beam.end[:3, :3].T
    start = np.zeros(3)
    np.testing.assert_allclose(x1, (beam.end[:3, 3] - start) / beam.length)
    np.testing.assert_allclose(x2, np.cross(x3, x1), atol=1e-15)
    assert x3[2] > 0.0
    assert x3 @ np.array([0.0, 0.0, 1.0]) == pytest.approx(np.sqrt(1 - x1[2] ** 2))
    rows = [{"name": "A1", "d_m": 0.3}, {"name": "A2", "d_m": 0.5, "link": {"name": "straight"}}]
    rows += [{"name": "A3", "d_m": 0.4}, {"name": "A4", "alpha_deg": -90.0, "d_m": 0.0}]
    coaxial = chain_of(robot({"convention": "modified-dh", "joints": rows}), Path())
    np.testing.assert_allclose(coaxial.beams["straight"].end[:3, 0], [0, 0, 1])
    lengths = {name: beam.length for name, beam in coaxial.beams.items()}
    assert lengths == pytest.approx({"link1": 0.5, "straight": 0.4})


def test_beam_ends_may_be_written() -> None:
    rows = [{"name": f"A{k}", "a_m": 0.5, "link": {"name": f"L{k}"}} for k in range(1, 4)]
    links = {"L1": {"from_m": [0.1, 0.0, 0.0], "to_m": [0.1, 0.3, 0.0]}, "L2": {"to_m": [0.04, 0.0, 0.0]}}
    chain = chain_of(robot({"convention": "modified-dh", "joints": rows, "links": links}), Path())
    assert list(chain.beams) == ["L1"]  # the other is shorter than 50 mm
    np.testing.assert_allclose(chain.beams["L1"].end[:3, 0], [0, 1, 0])


def test_couplings_directions_and_offsets() -> None:
    joints = [
        {"name": "J1"},
        {"name": "J2", "theta_deg": -90.0},
        {"name": "J3", "direction": -1, "logged": {"J2": 1, "J3": 1}, "coupling": "mechanical"},
    ]
    chain = chain_of(robot({"convention": "modified-dh", "joints": joints}), Path())
    logged = np.array([[0.1, 0.2, 0.3]])
    np.testing.assert_allclose(chain.model_angles(logged), [[0.1, 0.2 - np.pi / 2, -0.5]])
    assert chain.mechanical.tolist() == [False, False, True]


def test_names_of_links() -> None:
    assert dh_chain().link_names == ("link1", "swing", "arm", "link4", "link5", "link6")
    rows: list[dict[str, Any]] = [{"name": f"A{k}", "d_m": 0.5} for k in range(1, 8)]
    rows[3]["link"] = {"name": "arm"}
    seven = chain_of(robot({"convention": "modified-dh", "joints": rows}), Path())
    assert seven.link_names == ("link1", "link2", "link3", "arm", "link5", "link6", "link7")
    six = [{"name": f"A{k}", "a_m": 0.5, "link": {"name": f"L{k}"}} for k in range(1, 7)]
    assert list(chain_of(robot({"convention": "modified-dh", "joints": six}), Path()).beams) == [
        "L1", "swing", "arm", "L4", "L5",
    ]  # fmt: skip


def test_a_link_that_is_called_swing_keeps_the_name_to_itself() -> None:
    """Six axes, the third joint's link called swing: the second's is then link2, as a body and as a beam."""
    rows: list[dict[str, Any]] = [{"name": f"A{k}", "a_m": 0.5} for k in range(1, 7)]
    rows[2]["link"] = {"name": "swing"}
    found = chain_of(robot({"convention": "modified-dh", "joints": rows}), Path())
    assert found.link_names[:3] == ("link1", "link2", "swing")
    assert {name: beam.joint for name, beam in found.beams.items()}["link2"] == 2


def test_urdf_agrees_with_pinocchio() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    model = pinocchio.buildModelFromUrdf(str(DATA / "six.urdf"))
    data = model.createData()
    chain = chain_of(robot({"urdf": "six.urdf"}), DATA)
    assert chain.joint_names == ("J1", "J2", "J3", "J4", "J5", "J6")
    assert chain.masses_known
    rng = np.random.default_rng(1)
    for _ in range(5):
        q = rng.uniform(-2, 2, 6)
        stacked = np.concatenate([q[:3], [np.cos(q[3]), np.sin(q[3])], q[4:]])  # joint 4 is continuous
        pinocchio.framesForwardKinematics(model, data, stacked)
        found = frames(chain, q)
        tool = data.oMf[model.getFrameId("tool0")].homogeneous
        np.testing.assert_allclose(found[-1], tool, atol=1e-12)
        for k in range(6):
            theirs = data.oMi[k + 1]
            np.testing.assert_allclose(found[k][:3, 3], theirs.translation, atol=1e-12)
            com = theirs.act(model.inertias[k + 1].lever)
            np.testing.assert_allclose(found[k][:3, :3] @ chain.link_com[k] + found[k][:3, 3], com, atol=1e-12)
            assert chain.link_mass[k] == pytest.approx(model.inertias[k + 1].mass)
        torque = pinocchio.computeGeneralizedGravity(model, data, stacked)
        np.testing.assert_allclose(weight_torque(chain, q), torque, rtol=1e-9, atol=1e-9)


def weight_torque(chain: Chain, q: Floats) -> Floats:
    """Torque that holds the weight: minus the moment of every outboard weight about each axis."""
    found = frames(chain, q)
    masses = [
        (f[:3, :3] @ com + f[:3, 3], m) for f, com, m in zip(found, chain.link_com, chain.link_mass, strict=False)
    ]
    total = np.zeros(6)
    for k in range(6):
        for place, mass in masses[k:]:
            total[k] -= found[k][:3, 2] @ np.cross(place - found[k][:3, 3], mass * chain.gravity)
    return total


def test_urdf_limits_count_for_the_logged_angle() -> None:
    joints = [{"name": "J1", "direction": -1, "theta_deg": 10.0}, {"name": "J2", "limits_deg": [-5, 5]}]
    chain = chain_of(robot({"urdf": "six.urdf", "joints": joints}), DATA)
    offset = np.deg2rad(10)
    np.testing.assert_allclose(chain.limits[0], [-2 + offset, 3 + offset])
    np.testing.assert_allclose(chain.limits[1], np.deg2rad([-5, 5]))
    assert np.isinf(chain.limits[3]).all()


def test_urdf_axis_along_minus_z() -> None:
    chain = chain_of(robot({"urdf": "six.urdf"}), DATA)
    np.testing.assert_allclose(chain.fixed[0][:3, 2], [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(chain.fixed[0][:3, :3] @ chain.fixed[0][:3, :3].T, np.eye(3), atol=1e-15)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("</robot>", ""), "not valid XML"),
        (('xyz="0 0 0.1"', 'xyz="0 0,1"'), "is not three numbers"),
        (('<joint name="J3" type="revolute">', '<joint name="J3" type="planar">'), "a planar joint"),
        (('<axis xyz="0 0 -1"/>', '<axis xyz="0 0 0"/>'), "axis is zero"),
    ],
)
def test_urdf_faults(tmp_path: Path, change: tuple[str, str], words: str) -> None:
    text = (DATA / "six.urdf").read_text()
    assert change[0] in text
    (tmp_path / "broken.urdf").write_text(text.replace(*change))
    with pytest.raises(InputError, match=words):
        read_urdf(tmp_path / "broken.urdf", "broken.urdf", tip_link="tool0")


def test_urdf_that_branches_needs_its_tip(tmp_path: Path) -> None:
    assert read_urdf(DATA / "six.urdf", "six.urdf").tip == "tool0"  # the cover hangs on joint 4
    text = (DATA / "six.urdf").read_text()
    (tmp_path / "two.urdf").write_text(text.replace('link="l4"/><child link="cover"', 'link="l6"/><child link="cover"'))
    with pytest.raises(InputError, match="2 links could be the tip_link: cover, tool0"):
        read_urdf(tmp_path / "two.urdf", "two.urdf")
    assert read_urdf(tmp_path / "two.urdf", "two.urdf", tip_link="tool0").base == "world"


def test_interface_example_of_a_robot_file(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text((DATA / "interface_robot.toml").read_text(encoding="utf-8"), encoding="utf-8")
    found = load_robot(tmp_path / "robot.toml")
    assert found.joints[0].link.name == "carousel"
    document = tomllib.loads((DATA / "interface_robot.toml").read_text(encoding="utf-8"))
    document["joints"][0] |= {
        "logged": {"A1": 1}, "coupling": "mechanical", "gear_ratio": -80.0, "gear_orders": [80, 160], "bearing_m": 0.1,
    }  # fmt: skip
    document["gravity_compensator"] = {
        "joint": 1, "anchor_m": [0, 0, 0], "arm_m": [0.1, 0, 0], "rate_N_m": 2e4, "preload_N": 100.0,
    }  # fmt: skip
    document["links"] = {
        "carousel": {
            "from_m": [0, 0, 0], "to_m": [0, 0, 0.4], "warping_decay_m": 0.05,
            "section": {"outline": [[0, 0], [0.1, 0], [0, 0.1]], "EI": 1e6, "GJ": 1e6, "EA": 1e9},
        }
    }  # fmt: skip
    chain = chain_of(RobotFile.model_validate(document), tmp_path)
    assert chain.gear_orders == ((80, 160),)
    assert chain.compensator is not None
    assert chain.beams["carousel"].length == pytest.approx(0.4)
