"""Meshes of a stranger's campaign: nothing outside the folder is read, and no file takes more than it may."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.robot.link_shapes import link_shapes
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.meshes.client import PlacedShape, read_bodies
from tests.campaign.test_link_shapes import ROBOT, shape, write_urdf
from tests.laboratory.mesh_robot import binary_stl, tube

STL = binary_stl(tube([0.0, 0.0, 0.0], [0.0, 0.0, 0.5], (0.1, 0.1)))


def codes(error: InputError) -> list[FaultCode]:
    return [fault.code for fault in error.faults]


def meshes_of(folder: Path, name: str) -> list[PlacedShape]:
    write_urdf(folder / "arm.urdf", "", shape(name))
    return link_shapes(ROBOT, folder, "robot.toml")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a campaign folder next to a file that is not its business."""
    (tmp_path / "secret.stl").write_bytes(STL)
    (tmp_path / "campaign" / "meshes").mkdir(parents=True)
    return tmp_path / "campaign"


@pytest.mark.parametrize(
    "name",
    [
        "../secret.stl",
        "meshes/../../secret.stl",
        "..\\secret.stl",
        "C:\\secret.stl",
        "{outside}/secret.stl",
        "file://{outside}/secret.stl",
        "file:///C:/secret.stl",
        "http://example.org/secret.stl",
        "package://../secret.stl",
        "package://arm/../../secret.stl",
        "package://arm/{outside}/secret.stl",
        "package://{outside}/secret.stl",
        "model:///secret.stl",
    ],
)
def test_a_name_that_leads_out_of_the_folder_is_refused(folder: Path, name: str) -> None:
    with pytest.raises(InputError) as caught:
        meshes_of(folder, name.format(outside=folder.parent))
    assert codes(caught.value) == [FaultCode.FILE_OUTSIDE]


@pytest.mark.parametrize("link", ["meshes/part.stl", "meshes"])
def test_a_link_out_of_the_folder_is_refused(folder: Path, link: str) -> None:
    goal = folder.parent if link == "meshes" else folder.parent / "secret.stl"
    if link == "meshes":
        (folder / "meshes").rmdir()
        (folder.parent / "part.stl").write_bytes(STL)
    (folder / link).symlink_to(goal)
    with pytest.raises(InputError) as caught:
        meshes_of(folder, "meshes/part.stl")
    assert codes(caught.value) == [FaultCode.FILE_OUTSIDE]


def read(folder: Path, *files: str, place: np.ndarray | None = None) -> int:
    """Return the number of triangles of meshes on one link."""
    own = np.eye(4) if place is None else place
    found = read_bodies(folder, [PlacedShape(1, file, own) for file in files], 500, "arm.urdf")
    return sum(len(surface.triangles) for surface in found.values())


def test_a_pipe_is_no_mesh_and_nobody_waits_for_it(folder: Path) -> None:
    os.mkfifo(folder / "part.stl")
    assert [mesh.source for mesh in meshes_of(folder, "part.stl")] == ["part.stl"]
    with pytest.raises(InputError) as caught:
        read(folder, "part.stl")
    assert codes(caught.value) == [FaultCode.FILE_KIND]


def test_a_folder_and_a_missing_file_are_one_fault(folder: Path) -> None:
    (folder / "part.stl").mkdir()
    for name in ("part.stl", "gone.stl"):
        with pytest.raises(InputError) as caught:
            read(folder, name)
        assert len(caught.value.faults) == 1


def test_all_meshes_together_have_a_limit_of_bytes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a.stl", "b.stl"):
        (folder / name).write_bytes(STL)
    monkeypatch.setenv("STIFFCAL_MAX_MESHES", str(int(1.5 * len(STL))))
    assert 0 < read(folder, "a.stl") <= 500
    with pytest.raises(InputError, match="STIFFCAL_MAX_MESHES") as caught:
        read(folder, "a.stl", "b.stl")
    assert codes(caught.value) == [FaultCode.SIZE_EXCEEDED]


def test_a_robot_of_more_meshes_than_any_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "part.stl").write_bytes(STL)
    monkeypatch.setenv("STIFFCAL_MAX_ENTRIES", "20")
    write_urdf(folder / "arm.urdf", 21 * shape("part.stl"))
    with pytest.raises(InputError, match="STIFFCAL_MAX_ENTRIES") as caught:
        link_shapes(ROBOT, folder, "robot.toml")
    assert codes(caught.value) == [FaultCode.SIZE_EXCEEDED]


def test_a_mesh_in_another_unit_is_one_fault(folder: Path) -> None:
    (folder / "part.stl").write_bytes(STL)
    with pytest.raises(InputError) as caught:
        read(folder, "part.stl", place=np.diag([1000.0, 1000.0, 1000.0, 1.0]))
    assert codes(caught.value) == [FaultCode.UNIT_IMPLAUSIBLE]


@pytest.mark.long
def test_a_mesh_that_takes_too_long_ends_as_one_fault(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFCAL_MAX_SECONDS", "1")
    corners = b"".join(b"v %d %d %d\n" % (k % 97, k % 89, k % 83) for k in range(3000))
    (folder / "part.obj").write_bytes(corners + b"f " + b"1 2 3 " * 2_000_000 + b"\n")
    with pytest.raises(InputError) as caught:
        read(folder, "part.obj")
    assert codes(caught.value) == [FaultCode.SIZE_EXCEEDED]
