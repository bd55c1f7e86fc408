"""Kinematics and loads that contradict what was measured: the change that fits is named, sound campaigns pass."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import Fault, InputError, no_progress
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.mistakes.catalogue.loads.wrench_columns import FORCES_ALONE
from stiffcal.mistakes.displacements.springs import work_of_load
from stiffcal.mistakes.displacements.work import check_work
from stiffcal.mistakes.references.kinematics import check_kinematics
from stiffcal.mistakes.references.match import match_kinematics
from stiffcal.quantities import unit
from stiffcal.quaternions import quaternion_from_rotation, rotation_from_quaternion
from tests.laboratory.hidden_campaigns import NAMES, copied, folder_of, reduced
from tests.laboratory.robots import DEGREES


@pytest.mark.parametrize("name", NAMES)
def test_sound_campaigns_pass(name: str) -> None:
    states, chain = reduced(name).states, load_campaign(folder_of(name)).chain
    assert check_work(states, chain) == []
    assert check_kinematics(states, chain, estimated=False, stated=DEGREES) == []
    assert (work_of_load(states, chain).work > 0.0).all()
    assert match_kinematics(states, chain).median_m < 0.006


def test_a_sensor_upside_down_is_distinguished_from_acts_on() -> None:
    states, chain = reduced("04").states, load_campaign(folder_of("04")).chain
    (fault,) = check_work(replace(states, wrench=-states.wrench), chain)
    assert fault.changes == (InputChange("acts-on", value="environment"),)
    (fault,) = check_work(replace(states, wrench=-states.wrench), chain, acts_on="environment")
    assert fault.changes == (InputChange("acts-on", value="robot"),)
    for k, axis in enumerate("xyz"):
        signs = np.where(np.arange(6) % 3 == k, 1.0, -1.0)
        (fault,) = check_work(replace(states, wrench=states.wrench * signs), chain)
        assert fault.changes == (InputChange("sensor-axes", (axis,), (np.pi,)),)


@pytest.mark.parametrize("name", ["04", "07", "11"])
@pytest.mark.parametrize("order", [(0, 2, 1), (1, 0, 2), (2, 0, 1), (2, 1, 0)])
def test_the_order_of_the_force_columns_is_named(name: str, order: tuple[int, ...]) -> None:
    states, chain = reduced(name).states, load_campaign(folder_of(name)).chain
    read = replace(states, wrench=states.wrench[:, [*order, 3, 4, 5]])
    columns = [*("abc"[k] for k in order), "d", "e", "f"]  # a holds Fx, b Fy
    (fault,) = check_work(read, chain, columns=tuple(columns))
    assert [change.kind for change in fault.changes] == ["wrench-columns"]
    assert _is_right_order(fault.changes[0])
    moments = [3 + k for k in order]
    read = replace(states, wrench=states.wrench[:, [*order, *moments]])
    (fault,) = check_work(read, chain, columns=(*columns[:3], *("abcdef"[k] for k in moments)))
    assert [change.kind for change in fault.changes] == ["wrench-columns"]
    assert _is_right_order(fault.changes[0])


@pytest.mark.parametrize("order", [(0, 1, 2, 4, 3, 5), (0, 1, 3, 2, 4, 5), (3, 4, 5, 0, 1, 2)])
def test_columns_of_moments_in_another_order_are_named(order: tuple[int, ...]) -> None:
    """Those of two moments, of a force and a moment, of all."""
    states, chain = reduced("03").states, load_campaign(folder_of("03")).chain
    read = replace(states, wrench=states.wrench[:, order])
    (fault,) = check_work(read, chain, columns=tuple("abcdef"[k] for k in order))
    assert [(change.kind, change.names) for change in fault.changes] == [("wrench-columns", tuple("abcdef"))]


@pytest.mark.parametrize(
    ("name", "logged", "stated"),
    [
        ("01", ("N", "N*m"), ("lbf", "N*m")),
        ("01", ("N", "N*m"), ("N", "N*mm")),
        ("01", ("N", "N*mm"), ("N", "N*m")),
        ("03", ("N", "N*m"), ("N", "kN*m")),  # play leaves lbf*ft open, which is named after N*m
    ],
)
def test_units_of_forces_against_moments_are_named(name: str, logged: tuple[str, str], stated: tuple[str, str]) -> None:
    states, chain = reduced(name).states, load_campaign(folder_of(name)).chain
    factors = [unit(stated[k], of).factor / unit(logged[k], of).factor for k, of in enumerate(("force", "moment"))]
    read = replace(states, wrench=states.wrench * np.repeat(factors, 3))
    (fault,) = check_work(read, chain, units=stated)
    assert [(change.kind, change.names) for change in fault.changes] == [("load-units", logged)]
    # by one factor all compliances are others, and no displacement is
    assert check_work(replace(states, wrench=4.448 * states.wrench), chain, units=("N", "N*m")) == []


def _is_right_order(change: InputChange) -> bool:
    """Return whether the columns are named in their order; the moments of few poses may leave theirs open."""
    right = ("a", "b", "c", "d", "e", "f")
    return change.names[:3] == right[:3] if change.value == FORCES_ALONE else change.names == right


@pytest.mark.parametrize("estimated", [False, True])
def test_the_one_change_that_fits_is_named(estimated: bool) -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain

    def named(joints: Floats) -> InputChange:
        (fault,) = check_kinematics(replace(states, joints=joints), chain, estimated, DEGREES)
        return fault.changes[0]

    for a, b in [(0, 1), (1, 2), (3, 5), (4, 5)]:
        swapped = states.joints.copy()
        swapped[:, [a, b]] = swapped[:, [b, a]]
        assert named(swapped) == InputChange("joint-order", (f"A{b + 1}", f"A{a + 1}"))
    turned = states.joints * np.where(np.arange(6) == 2, -1.0, 1.0)
    assert named(turned) == InputChange("direction", ("A3",))
    quarter = named(states.joints + np.where(np.arange(6) == 1, np.pi / 2, 0.0))
    assert (quarter.kind, quarter.names) == ("zero", ("A2",))
    assert quarter.sizes == pytest.approx((-np.pi / 2,), abs=0.02)


def test_tracker_axes_units_and_quaternion_order() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    there = states.setup.trackers[0].base_from_frame
    own = (states.position[:, 0] - there[:3, 3]) @ there[:3, :3]

    def named(readings: Floats) -> tuple[InputChange, ...]:
        position = (readings @ there[:3, :3].T + there[:3, 3])[:, None]
        (fault,) = check_kinematics(replace(states, position=position), chain, estimated=False, stated=DEGREES)
        return fault.changes

    assert named(own[:, [1, 0, 2]]) == (InputChange("tracker-axes", ("Y", "X", "Z")),)
    assert named(own / 1000.0) == (InputChange("length-unit", value="m"),)
    assert named(own * 1000.0) == (InputChange("length-unit", value="mm"),)
    quaternion = quaternion_from_rotation(there[:3, :3].T @ states.rotation[:, 0])
    wrong = there[:3, :3] @ rotation_from_quaternion(quaternion[:, [1, 2, 3, 0]])
    (fault,) = check_kinematics(replace(states, rotation=wrong[:, None]), chain, estimated=False, stated=DEGREES)
    assert fault.changes == (InputChange("quaternion-order"),)


def moved_by(places: Floats) -> Fault:
    """Return the fault where the measured places are these, (n, 3)."""
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    (fault,) = check_kinematics(replace(states, position=places[:, None]), chain, estimated=False, stated=DEGREES)
    return fault


def exact_places() -> Floats:
    """Return where kinematics puts the target, with 0.4 mm of a robot's own inaccuracy."""
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    place, _ = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    off = np.random.default_rng(4).normal(size=(len(states.runs), 3))
    return np.asarray(place + 4e-4 * (off / np.linalg.norm(off, axis=1, keepdims=True))[states.run])


def test_a_tracker_frame_turned_by_some_degrees_is_named_with_what_it_leaves() -> None:
    turn = rotation_from_vector(np.radians([0.5, 1.7, -0.6]))
    fault = moved_by(exact_places() @ turn.T)
    (change,) = fault.changes
    assert change.kind == "tracker-frame"
    assert change.sizes[:3] == pytest.approx(np.radians([-0.5, -1.7, 0.6]), abs=np.radians(0.05))
    # the turn is about the middle of the places, and in one line the words are made of it
    assert "rotated by 1.9°" in str(fault)


def test_a_target_elsewhere_on_the_flange_is_named_with_its_offset() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    _, turn = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    fault = moved_by(exact_places() + turn @ np.array([0.06, 0.0, -0.03]))
    assert fault.changes[0].kind == "target"
    assert fault.changes[0].sizes == pytest.approx((0.06, 0.0, -0.03), abs=1e-3)


def test_zeros_of_one_joint_and_of_several_are_named() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    places = exact_places()[:, None]
    one = states.joints + np.radians([0.0, 4.0, 0.0, 0.0, 0.0, 0.0])
    (fault,) = check_kinematics(replace(states, joints=one, position=places), chain, estimated=False, stated=DEGREES)
    assert (fault.changes[0].kind, fault.changes[0].names) == ("zero", ("A2",))
    assert fault.changes[0].sizes == pytest.approx(np.radians([-4.0]), abs=np.radians(0.02))
    several = states.joints + np.radians([0.0, 3.0, -2.0, 0.0, 2.0, 0.0])
    (fault,) = check_kinematics(
        replace(states, joints=several, position=places), chain, estimated=False, stated=DEGREES
    )
    assert fault.changes[0].names == chain.joint_names
    assert fault.changes[0].sizes[1:3] == pytest.approx(np.radians([-3.0, 2.0]), abs=np.radians(0.5))


def test_poses_in_another_order_are_named() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    first = np.array([own[0] for own in states.members()])
    joints = states.joints[np.roll(first, -1)][states.run]
    (fault,) = check_kinematics(replace(states, joints=joints), chain, estimated=False, stated=DEGREES)
    assert fault.changes[0].kind == "pose-order"
    assert fault.changes[0].names[:2] == ("pose01", "pose02")


def test_places_that_follow_no_rule_are_given_no_correction() -> None:
    states = reduced("01").states
    off = 0.06 * np.random.default_rng(0).normal(size=(len(states.runs), 3))
    fault = moved_by(exact_places() + off[states.run])
    assert fault.changes == ()


def test_a_target_mounted_turned_is_no_fault() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    mounting = rotation_from_quaternion(np.array([0.6, 0.0, 0.8, 0.0]))
    assert (
        check_kinematics(replace(states, rotation=states.rotation @ mounting), chain, estimated=False, stated=DEGREES)
        == []
    )


def test_the_one_change_is_named_where_no_frames_are_found(tmp_path: Path) -> None:
    folder = copied("01", tmp_path)
    manifest = folder / "campaign.toml"
    text = manifest.read_text("utf-8")
    estimated = re.sub(r"(\[frames.tracker\]\nparent = \"base\"\n)(.*\n){2}", r"\1estimate = true\n", text)
    manifest.write_text(estimated.replace('["A1", "A2", "A3",', '["A1", "A3", "A2",'), "utf-8")
    with pytest.raises(InputError) as found:
        reduce_campaign(load_campaign(folder), no_progress)
    (fault,) = found.value.faults
    assert (fault.code, fault.place) == (FaultCode.KINEMATICS_MISMATCH, "joints A2 and A3")
