"""Which meshes of a URDF lie in the campaign folder, and where they are on the robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.link_shapes import link_shapes
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.kinematics import body_poses

ROBOT = RobotFile.model_validate({"schema": "stiffcal/robot/1", "urdf": "arm.urdf", "tip_link": "l2"})
ORIGIN = '<origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/>'


def shape(file: str, kind: str = "visual", origin: str = ORIGIN, scale: str = "") -> str:
    return f'<{kind}>{origin}<geometry><mesh filename="{file}"{scale}/></geometry></{kind}>'


def write_urdf(path: Path, *shapes: str) -> Path:
    """Write an arm of two joints whose links base, l1, l2 and, next to the chain, cover and fence have these shapes."""
    names = ("base", "l1", "l2", "cover", "fence")
    given = [*shapes, *[""] * (len(names) - len(shapes))]
    links = "".join(f"<link name='{name}'>{given[k]}</link>" for k, name in enumerate(names))
    joints = (
        "<joint name='A1' type='revolute'><parent link='base'/><child link='l1'/><axis xyz='0 1 0'/>"
        "<origin xyz='0 0.1 0.5' rpy='0.2 0 0.3'/><limit lower='-3' upper='3' effort='0' velocity='0'/></joint>"
        "<joint name='A2' type='prismatic'><parent link='l1'/><child link='l2'/><axis xyz='0.6 0 -0.8'/>"
        "<origin xyz='0.4 0 0' rpy='0 0.7 0'/><limit lower='-1' upper='1' effort='0' velocity='0'/></joint>"
        "<joint name='screws' type='fixed'><parent link='l1'/><child link='cover'/>"
        "<origin xyz='0 0 0.2' rpy='0.1 0.2 0.3'/></joint>"
        "<joint name='bolts' type='fixed'><parent link='base'/><child link='fence'/></joint>"
    )
    path.write_text(f"<robot name='r'>{links}{joints}</robot>", encoding="utf-8")
    return path


def write(folder: Path, *files: str) -> None:
    for file in files:
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_bytes(b"solid\n")


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("part.stl", "part.stl"),
        ("meshes/part.STL", "meshes/part.STL"),
        ("./meshes/../part.obj", "part.obj"),
        ("package://arm/meshes/part.stl", "arm/meshes/part.stl"),
        ("package://arm/meshes/part.stl", "meshes/part.stl"),
        ("model://arm/part.stl", "part.stl"),
        ("meshes\\part.stl", "meshes/part.stl"),
    ],
)
def test_names_are_looked_for_in_the_folder(name: str, file: str, tmp_path: Path) -> None:
    write(tmp_path, file)
    write_urdf(tmp_path / "arm.urdf", shape(name))
    assert [mesh.source for mesh in link_shapes(ROBOT, tmp_path, "robot.toml")] == [file]


@pytest.mark.parametrize("name", ["package://arm/meshes/part.stl", "../meshes/part.stl"])
def test_names_in_a_package_are_looked_for_around_the_urdf(name: str, tmp_path: Path) -> None:
    write(tmp_path, "arm/urdf/x", "arm/meshes/part.stl")
    write_urdf(tmp_path / "arm" / "urdf" / "arm.urdf", shape(name))
    robot = ROBOT.model_copy(update={"urdf": "arm/urdf/arm.urdf"})
    assert [mesh.source for mesh in link_shapes(robot, tmp_path, "robot.toml")] == ["arm/meshes/part.stl"]


def test_meshes_that_are_not_in_the_folder_are_none(tmp_path: Path) -> None:
    write_urdf(tmp_path / "arm.urdf", shape("package://arm/meshes/part.stl"), shape("part.ply"))
    assert link_shapes(ROBOT, tmp_path, "robot.toml") == []
    rows = {"schema": "stiffcal/robot/1", "convention": "dh", "joints": [{"name": "A1", "d_m": 0.5}]}
    assert link_shapes(RobotFile.model_validate(rows), tmp_path, "robot.toml") == []


def test_meshes_for_collisions_stand_in_for_a_format_that_is_not_read(tmp_path: Path) -> None:
    write(tmp_path, "fine.ply", "plain.stl", "fine.stl")
    shapes = shape("fine.ply") + shape("plain.stl", "collision"), shape("fine.stl") + shape("plain.stl", "collision")
    write_urdf(tmp_path / "arm.urdf", *shapes)
    found = [(mesh.body, mesh.source) for mesh in link_shapes(ROBOT, tmp_path, "robot.toml")]
    assert found == [(0, "plain.stl"), (1, "fine.stl")]


SOLIDS = (
    '<{0}>{1}<geometry><box size="0.1 0.2 0.3"/></geometry></{0}>',
    (
        '<{0}>{1}<geometry><cylinder radius="0.1" length="0.5"/></geometry></{0}>'
        "<{0}>{1}<geometry><sphere radius='0.2'/></geometry></{0}><{0}><geometry><capsule radius='1'/></geometry></{0}>"
    ),
)


def test_boxes_cylinders_and_spheres_are_shapes_as_meshes_are(tmp_path: Path) -> None:
    box, round_ = (solid.format("visual", ORIGIN) for solid in SOLIDS)
    write(tmp_path, "part.stl")
    write_urdf(tmp_path / "arm.urdf", box, round_, shape("part.stl"))
    base, cylinder, sphere, mesh = link_shapes(ROBOT, tmp_path, "robot.toml")
    assert [one.source for one in (base, cylinder, sphere)] == ["box", "cylinder", "sphere"]
    own = cylinder.place @ np.diag([10.0, 10.0, 2.0, 1.0])  # sizes taken out again: the origin of both
    assert np.abs(sphere.place @ np.diag([5.0, 5.0, 5.0, 1.0]) - own).max() < 1e-12
    assert np.abs(np.linalg.norm(base.place[:3, :3], axis=0) - [0.1, 0.2, 0.3]).max() < 1e-12
    assert np.abs(base.place[:3, 3] - [0.1, -0.2, 0.3]).max() < 1e-12
    assert mesh.source == "part.stl"


def test_solids_for_collisions_stand_in_for_meshes_that_are_not_in_the_folder(tmp_path: Path) -> None:
    box = SOLIDS[0].format("collision", ORIGIN)
    write(tmp_path, "there.stl")
    half = shape("there.stl") + shape("gone.stl")
    write_urdf(tmp_path / "arm.urdf", shape("gone.stl") + box, half + box, half)
    found = [(one.body, one.source) for one in link_shapes(ROBOT, tmp_path, "robot.toml")]
    assert found == [(0, "box"), (1, "box"), (2, "there.stl")]


def test_what_stands_beside_the_chain_is_no_part_of_the_robot(tmp_path: Path) -> None:
    write(tmp_path, "base.stl", "cover.stl", "fence.stl")
    write_urdf(tmp_path / "arm.urdf", shape("base.stl"), "", "", shape("cover.stl"), shape("fence.stl"))
    found = [(mesh.body, mesh.source) for mesh in link_shapes(ROBOT, tmp_path, "robot.toml")]
    assert found == [(0, "base.stl"), (1, "cover.stl")]


@pytest.mark.parametrize(
    ("mesh", "code", "file"),
    [
        (shape("part.ply"), FaultCode.CONTENT_UNSUPPORTED, "part.ply"),
        (shape("part.stl", origin='<origin xyz="0 0"/>'), FaultCode.NUMBER_INVALID, "arm.urdf"),
        (shape("part.stl", origin='<origin xyz="0 0 1200"/>'), FaultCode.VALUE_INVALID, "arm.urdf"),
        (shape("part.stl", scale=' scale="1 1 nan"'), FaultCode.NUMBER_INVALID, "arm.urdf"),
        (shape("part.stl", scale=' scale="1 1 1e200"'), FaultCode.VALUE_INVALID, "arm.urdf"),
        (shape("part&#x202E;.stl"), FaultCode.NAME_INVALID, "arm.urdf"),
        (SOLIDS[0].format("visual", "").replace("0.2", "200"), FaultCode.VALUE_INVALID, "arm.urdf"),
        (SOLIDS[0].format("visual", "").replace("0.2", "-0.2"), FaultCode.VALUE_INVALID, "arm.urdf"),
        (SOLIDS[0].format("visual", "").replace("0.2", ""), FaultCode.NUMBER_INVALID, "arm.urdf"),
        (SOLIDS[1].format("visual", "").replace("radius", "r"), FaultCode.NUMBER_INVALID, "arm.urdf"),
        (SOLIDS[1].format("visual", "").replace("0.5", "inf"), FaultCode.VALUE_INVALID, "arm.urdf"),
    ],
)
def test_what_cannot_be_drawn_is_one_fault_and_spoils_no_fit(
    mesh: str, code: FaultCode, file: str, tmp_path: Path
) -> None:
    write(tmp_path, "part.stl", "part.ply")
    write_urdf(tmp_path / "arm.urdf", "", mesh)
    assert chain_of(ROBOT, tmp_path).n_joints == 2
    with pytest.raises(InputError) as caught:
        link_shapes(ROBOT, tmp_path, "robot.toml")
    assert [(fault.code, fault.file) for fault in caught.value.faults] == [(code, file)]


def test_they_are_where_pinocchio_puts_them(tmp_path: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    scale = ' scale="0.001 0.002 -0.003"'
    write(tmp_path, "part.stl")
    write_urdf(tmp_path / "arm.urdf", *(shape("part.stl", scale=scale) for _ in range(4)))
    model = pinocchio.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    position = np.array([0.7, -0.4])
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, position)
    own = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.4, -0.5, 0.6), np.array([0.1, -0.2, 0.3]))
    chain = chain_of(ROBOT, tmp_path)
    points, rotations = body_poses(chain, position[np.newaxis])
    corner = np.array([300.0, -200.0, 100.0])
    meshes = link_shapes(ROBOT, tmp_path, "robot.toml")
    assert sorted(mesh.body for mesh in meshes) == [0, 1, 1, 2]
    found = [points[0, one.body] + rotations[0, one.body] @ (one.place @ [*corner, 1.0])[:3] for one in meshes]
    # link 1 comes before what is screwed onto it
    for name, place in zip(("base", "l1", "cover", "l2"), found, strict=True):
        expected = data.oMf[model.getFrameId(name)] * own * (corner * [0.001, 0.002, -0.003])
        assert np.abs(place - expected).max() < 1e-12
