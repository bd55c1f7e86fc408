"""What of a URDF is a serial arm: closed loops, names twice, joints that follow others, kinds that no drive moves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.robot.urdf.chain import UrdfRobot, read_urdf
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.urdf_arm import arm_of_table

ARM = (("A1", "base", "l1"), ("A2", "l1", "l2"), ("A3", "l2", "l3"), ("A4", "l3", "tip"))


def urdf(
    folder: Path,
    joints: tuple[tuple[str, ...], ...],
    more: str = "",
    without: tuple[str, ...] = (),
    masses: float = 0.0,
) -> Path:
    """Write joints (name, parent, child, kind or what else stands in the element) and their links."""
    links = dict.fromkeys(link for joint in joints for link in joint[1:3])
    inertial = f"<inertial><mass value='{masses}'/></inertial>" if masses else ""
    text = "".join(f"<link name='{link}'>{inertial}</link>" for link in links if link not in without)
    for k, (name, parent, child, *rest) in enumerate(joints):
        kind, inside = rest[0] if rest else "revolute", rest[1] if len(rest) > 1 else ""
        text += (
            f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>"
            f"<origin xyz='0.1 0 0.3'/><axis xyz='0 {k % 2} {1 - k % 2}'/>{inside}</joint>"
        )
    path = folder / "robot.urdf"
    path.write_text(f"<robot name='r'>{text}{more}</robot>", encoding="utf-8")
    return path


def read(folder: Path, *ends: str | None) -> UrdfRobot:
    return read_urdf(folder / "robot.urdf", "robot.urdf", *ends)


def fault_of(folder: Path, *ends: str | None) -> InputError:
    with pytest.raises(InputError) as caught:
        read(folder, *ends)
    assert len(caught.value.faults) == 1
    return caught.value


PLATFORM = tuple(
    joint
    for k in "123"
    for joint in ((f"A{k}", "base", f"arm{k}"), (f"P{k}", f"arm{k}", f"rod{k}"), (f"Q{k}", f"rod{k}", "platform"))
)
LOOPS: dict[str, tuple[tuple[tuple[str, ...], ...], str]] = {
    "a platform on three limbs": (PLATFORM, ""),
    "each limb with a base of its own": (
        (("P1", "base", "arm1"), ("Q1", "arm1", "tip"), ("P2", "ground", "arm2"), ("Q2", "arm2", "tip")), "",
    ),
    "a rod between two links of the arm": ((*ARM, ("R1", "l1", "rod"), ("R2", "l3", "rod")), ""),
    "a rod that ends on the arm": ((*ARM, ("R1", "l1", "rod"), ("R2", "rod", "l3")), ""),
    "a rod in two parts": ((*ARM, ("R1", "l1", "r1"), ("R2", "l3", "r2"), ("R3", "r1", "r2")), ""),
    "a joint that is written as closing one": (
        (*ARM, ("R1", "l1", "rod")), "<loop_joint name='c'><link1 link='rod'/><link2 link='l3'/></loop_joint>",
    ),
    "a fixed second way": ((*ARM, ("F", "l1", "l3", "fixed")), ""),
    "a joint from the tip to a link before": ((*ARM, ("R1", "tip", "l1")), ""),
}  # fmt: skip


@pytest.mark.parametrize("name", LOOPS)
def test_a_chain_in_a_loop_is_refused(tmp_path: Path, name: str) -> None:
    joints, more = LOOPS[name]
    urdf(tmp_path, joints, more)
    tip = "platform" if joints is PLATFORM else "tip"
    found = fault_of(tmp_path, "base", tip)
    assert found.code is FaultCode.URDF_LOOP
    assert found.file == "robot.urdf"


def test_the_joints_of_the_loop_are_named(tmp_path: Path) -> None:
    urdf(tmp_path, PLATFORM)
    assert all(joint in fault_of(tmp_path).reason for joint in ("A1", "P1", "Q1"))


def test_a_joint_whose_child_is_the_base_is_a_loop(tmp_path: Path) -> None:
    urdf(tmp_path, (*ARM, ("A5", "tip", "base")))
    assert fault_of(tmp_path).code is FaultCode.URDF_LOOP
    assert fault_of(tmp_path, "base", "tip").code is FaultCode.URDF_LOOP


@pytest.mark.parametrize("back_to", ["l1", "l3"])
def test_joints_that_lead_back_and_to_no_tip_are_a_loop(tmp_path: Path, back_to: str) -> None:
    path = urdf(tmp_path, (*ARM, ("A5", "tip", back_to)))
    assert fault_of(tmp_path).code is FaultCode.URDF_LOOP
    with pytest.raises(InputError) as caught:
        arm_of_table(path, ())
    assert caught.value.code is FaultCode.URDF_LOOP


def test_a_loop_that_hangs_on_one_link_rides_along_and_its_mass_counts_once(tmp_path: Path) -> None:
    fingers = (("G1", "tip", "g1"), ("G2", "tip", "g2"), ("G3", "g1", "jaw"), ("G4", "g2", "jaw"), ("G5", "jaw", "g1"))
    urdf(tmp_path, (*ARM, *fingers), masses=2.0)
    assert [joint.name for joint in read(tmp_path, "base", "tip").path] == ["A1", "A2", "A3", "A4"]
    settings = {"schema": "stiffcal/robot/1", "urdf": "robot.urdf", "tip_link": "tip"}
    chain = chain_of(RobotFile.model_validate(settings), tmp_path)
    np.testing.assert_allclose(chain.link_mass, [2.0, 2.0, 2.0, 8.0])


def test_a_loop_before_the_base_does_not_matter(tmp_path: Path) -> None:
    legs = (("L1", "world", "base"), ("L2", "world", "leg"), ("L3", "leg", "base"))
    urdf(tmp_path, (*legs, *ARM))
    assert fault_of(tmp_path, "world", "tip").code is FaultCode.URDF_LOOP
    assert len(read(tmp_path, "base", "tip").moving) == 4


def test_a_link_that_nothing_holds_closes_no_loop(tmp_path: Path) -> None:
    urdf(tmp_path, (*ARM, ("C1", "stand", "camera")))
    assert len(read(tmp_path, "base", "tip").moving) == 4


def test_of_a_table_only_the_part_with_columns_counts(tmp_path: Path) -> None:
    """Fingers in a loop behind the last joint that was logged are no part of the chain; a loop in it is."""
    from stiffcal.propose.table_sniffing import SniffedColumn

    columns = [SniffedColumn(name, name, None, (0.1,)) for name in ("A1", "A2", "A3", "A4")]
    fingers = (("G1", "tip", "g1"), ("G2", "tip", "g2"), ("G3", "g1", "jaw"), ("G4", "g2", "jaw"))
    arm = arm_of_table(urdf(tmp_path, (*ARM, *fingers)), columns)
    assert [line.toml for line in arm.lines] == ['tip_link = "tip"']
    with pytest.raises(InputError) as caught:
        arm_of_table(urdf(tmp_path, (*ARM, ("R1", "l1", "rod"), ("R2", "l3", "rod"))), columns)
    assert caught.value.code is FaultCode.URDF_LOOP


@pytest.mark.parametrize(
    ("joints", "more", "code"),
    [
        (ARM, "<link name='l2'/>", FaultCode.NAME_DUPLICATE),
        ((*ARM, ("A2", "l2", "cover", "fixed")), "", FaultCode.NAME_DUPLICATE),
        ((*ARM, ("A5", "tip", "left"), ("A6", "tip", "right")), "", FaultCode.URDF_INVALID),
        ((*ARM[:3], ("A4", "l3", "tip", "floating")), "", FaultCode.URDF_INVALID),
        ((*ARM[:3], ("A4", "l3", "tip", "planar")), "", FaultCode.URDF_INVALID),
        ((("A0", "world", "base", "floating"), *ARM), "", FaultCode.URDF_INVALID),
    ],
)
def test_what_else_is_no_serial_arm(
    tmp_path: Path, joints: tuple[tuple[str, ...], ...], more: str, code: FaultCode
) -> None:
    urdf(tmp_path, joints, more)
    assert fault_of(tmp_path).code is code


def test_a_joint_of_a_link_that_is_not_there(tmp_path: Path) -> None:
    urdf(tmp_path, ARM, without=("l2",))
    found = fault_of(tmp_path)
    assert (found.code, found.place) == (FaultCode.LINK_UNKNOWN, "joint A2")


def test_a_joint_that_follows_another_is_stated_in_the_robot_file(tmp_path: Path) -> None:
    """The cure that the fault names works as it is written."""
    mimic = "<mimic joint='A2' multiplier='-1' offset='0.5'/>"
    urdf(tmp_path, (*ARM[:3], ("A4", "l3", "tip", "revolute", mimic)))
    mend = fault_of(tmp_path).mend
    assert 'name = "A4", logged = { A2 = -1.0 }, theta_deg = 28.6479' in mend
    urdf(tmp_path, ARM)
    entry = {"name": "A4", "logged": {"A2": -1.0}, "theta_deg": 28.6479}
    settings = {"schema": "stiffcal/robot/1", "urdf": "robot.urdf", "joints": [entry]}
    chain = chain_of(RobotFile.model_validate(settings), tmp_path)
    assert chain.model_angles(np.array([[0.0, 0.2, 0.0, 0.7]]))[0, 3] == pytest.approx(0.3, abs=1e-5)


def test_a_long_chain_is_read_in_linear_time(tmp_path: Path) -> None:
    """Hostile: 20 000 links, each joined to its neighbours twice; quadratic work would take minutes."""
    links = [f"l{k}" for k in range(20_000)]
    chain = tuple((f"J{k}", links[k], links[k + 1]) for k in range(len(links) - 1))
    parallel = tuple((f"K{k}", links[k], f"r{k}", "fixed") for k in range(len(links) - 1))
    urdf(tmp_path, (*chain, *parallel))
    assert fault_of(tmp_path, "l0", links[-1]).code is FaultCode.SIZE_EXCEEDED


def test_two_joints_that_follow_none_of_the_chain(tmp_path: Path) -> None:
    urdf(tmp_path, (*ARM[:3], ("A4", "l3", "tip", "revolute", "<mimic joint='finger'/>")))
    assert "not on the chain" in fault_of(tmp_path).mend
