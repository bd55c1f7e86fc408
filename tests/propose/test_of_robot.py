"""`init --robot` and `init --urdf` without a table; the folder of a package in place of its URDF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.init import init_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode


def urdf_text(joints: int) -> str:
    mesh = '<visual><geometry><mesh filename="package://arm/meshes/base.stl"/></geometry></visual>'
    lines = [f'<robot name="arm"><link name="l0">{mesh}</link>']
    for k in range(1, joints + 1):
        lines.append(
            f'<link name="l{k}"/><joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
        )
        lines.append(f'<origin xyz="0 0 0.3"/><axis xyz="0 {k % 2} {(k + 1) % 2}"/>')
        lines.append('<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>')
    return "".join([*lines, "</robot>"])


@pytest.fixture
def package(tmp_path: Path) -> Path:
    (tmp_path / "arm" / "urdf").mkdir(parents=True)
    (tmp_path / "arm" / "package.xml").write_text("<package/>")
    (tmp_path / "arm" / "urdf" / "arm.urdf").write_text(urdf_text(7))
    (tmp_path / "arm" / "urdf" / "macros.xacro").write_text("<robot/>")
    return tmp_path / "arm"


@pytest.mark.parametrize("inside", ["", "urdf/arm.urdf"])
@pytest.mark.parametrize("option", ["urdf", "robot"])
def test_the_robot_of_a_package_is_in_the_folder(package: Path, tmp_path: Path, inside: str, option: str) -> None:
    given = {"urdf": package / inside} if option == "urdf" else {"robot": str(package / inside)}
    init_campaign(tmp_path / "cell", **given)
    campaign = load_campaign(tmp_path / "cell", check_files=False)
    assert campaign.chain.joint_names == tuple(f"j{k}" for k in range(1, 8))
    joints = campaign.manifest.sources["controller"].joints
    assert joints is not None
    assert joints.position == tuple(f"A{k}" for k in range(1, 8))


def test_a_bundled_robot_is_in_the_folder(tmp_path: Path) -> None:
    init_campaign(tmp_path / "cell", robot="kr125")
    assert len(load_campaign(tmp_path / "cell", check_files=False).chain.joint_names) == 6


def fault(folder: Path, urdf: Path) -> InputError:
    with pytest.raises(InputError) as caught:
        init_campaign(folder, urdf=urdf)
    assert not folder.exists()
    return caught.value


def test_what_is_no_single_urdf_is_named(package: Path, tmp_path: Path) -> None:
    cell = tmp_path / "cell"
    (package / "urdf" / "other.urdf").write_text(urdf_text(6))
    assert fault(cell, package).code == FaultCode.OPTION_INVALID
    (package / "urdf" / "other.urdf").unlink()
    (package / "urdf" / "arm.urdf").rename(package / "urdf" / "arm.urdf.xacro")
    for given in (package, package / "urdf" / "arm.urdf.xacro"):
        found = fault(cell, given)
        assert found.code == FaultCode.URDF_INVALID
        assert f"xacro {package / 'urdf' / 'arm.urdf.xacro'} > arm.urdf" in str(found)
    assert fault(cell, package / "meshes.urdf").code == FaultCode.FILE_MISSING
    (tmp_path / "empty").mkdir()
    assert fault(cell, tmp_path / "empty").code == FaultCode.FILE_MISSING


def test_a_package_without_a_urdf_is_named_with_the_option(package: Path, tmp_path: Path) -> None:
    (package / "urdf" / "arm.urdf").unlink()
    with pytest.raises(InputError) as caught:
        init_campaign(tmp_path / "cell", robot=str(package))
    (only,) = caught.value.faults
    assert (only.code, only.place) == (FaultCode.FILE_MISSING, "--robot")


def test_a_folder_called_like_a_bundled_robot_is_not_meant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "kr125").mkdir()
    init_campaign(tmp_path / "cell", robot="kr125")
    assert len(load_campaign(tmp_path / "cell", check_files=False).chain.joint_names) == 6


@pytest.mark.parametrize("further", [{}, {"kind": "load", "tool": (0.0, 0.0, 0.2)}])
def test_two_robots_are_refused(package: Path, tmp_path: Path, further: dict[str, Any]) -> None:
    with pytest.raises(InputError) as caught:
        init_campaign(tmp_path / "cell", urdf=package, robot="kr125", **further)
    (only,) = caught.value.faults
    assert (only.code, only.place) == (FaultCode.OPTION_CONFLICT, "--urdf")
    assert not (tmp_path / "cell").exists()
