"""ROS 2 bags and MCAP: fields by path, joints by name, transforms by frame; what is broken is one line."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.campaign.found.file_formats import format_names
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.bags import joint_state, pose, transforms, wrench, write_bag
from tests.laboratory.log_reading import parse_here, read_columns, refusal

START = 1_795_248_930_000_000_000
MOMENTS = [START + k * 2_000_000 for k in range(250)]
LOADS = np.random.default_rng(2).normal(size=(250, 6))
ANGLES = np.random.default_rng(3).normal(size=(250, 2))
FIRST, LAST = ["A1", "arm.2"], ["arm.2", "A1"]


def topics() -> dict[str, list[tuple[int, Any]]]:
    angles = [
        # the order of the names changes half-way: that is legal, and some drivers do
        joint_state(moment, FIRST if k < 100 else LAST, ANGLES[k] if k < 100 else ANGLES[k, ::-1])
        for k, moment in enumerate(MOMENTS)
    ]
    rows = list(zip(MOMENTS, LOADS, strict=True))
    return {
        "/ft": [(moment + 7, wrench(moment, load)) for moment, load in rows],
        "/joint_states": list(zip(MOMENTS, angles, strict=True)),
        "/tool": [(moment, pose(moment, load[:3], (1.0, 0.0, 0.0, 0.0))) for moment, load in rows],
        "/tf": [(moment, transforms(moment, {"a": load[:3], "b": load[3:]})) for moment, load in rows],
    }


@pytest.fixture(scope="module", params=["log.mcap", "log.db3", "log", "log.bag"])
def bag(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("bags") / request.param, topics())


def read(path: Path, wanted: WantedColumns, **options: object) -> dict[str, Any]:
    return read_columns(find_reader(path), path, options, wanted, "raw/log")


def fault(path: Path, wanted: WantedColumns, **options: object) -> str:
    return refusal(lambda: read(path, wanted, **options))


def test_fields_by_path(bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 90)
    names = ("time", "header.stamp", "wrench.force.x", "wrench.torque.z")
    found = read(bag, WantedColumns(names, texts=("header.frame_id",)), topic="/ft")
    assert np.array_equal(found["wrench.force.x"], LOADS[:, 0])
    assert np.array_equal(found["wrench.torque.z"], LOADS[:, 5])
    assert np.allclose(found["header.stamp"], np.array(MOMENTS) / 1e9, rtol=0, atol=3e-7)
    assert set(found["header.frame_id"]) == {"base"}
    header = find_reader(bag).read_header(bag, {"topic": "/ft"})
    assert header.n_rows == 250
    assert header.units == {"time": "s", "header.stamp": "s"}


def test_joints_by_name_in_any_order(bag: Path) -> None:
    found = read(bag, WantedColumns(("position.A1", "position.arm.2")), topic="/joint_states")
    assert np.array_equal(found["position.A1"], ANGLES[:, 0])
    assert np.array_equal(found["position.arm.2"], ANGLES[:, 1])


def test_poses_and_transforms(bag: Path) -> None:
    found = read(bag, WantedColumns(("pose.position.y", "pose.orientation.w")), topic="/tool")
    assert np.array_equal(found["pose.position.y"], LOADS[:, 1])
    assert set(found["pose.orientation.w"]) == {1.0}
    found = read(bag, WantedColumns(("transform.translation.x",)), topic="/tf", child_frame="b")
    assert np.array_equal(found["transform.translation.x"], LOADS[:, 3])


def test_faults_are_one_clear_line(bag: Path) -> None:
    wanted = WantedColumns(("wrench.force.x",))
    assert "topic: the bag contains 4 topics; state which: /ft (geometry_msgs/msg/WrenchStamped)" in fault(bag, wanted)
    assert "no topic '/fts'; did you mean '/ft'?" in fault(bag, wanted, topic="/fts")
    assert "topic /ft: no column 'wrench.force.X'; did you mean 'wrench.force.x'?" in fault(
        bag, WantedColumns(("wrench.force.X",)), topic="/ft"
    )
    assert "transforms of several frames" in fault(bag, WantedColumns(("transform.translation.x",)), topic="/tf")
    reported = fault(bag, WantedColumns(("transform.translation.x",)), topic="/tf", child_frame="c")
    assert "no transform of frame 'c' in /tf" in reported
    assert "there are 'a', 'b'" in reported
    reported = fault(bag, wanted, topic="/ft", types="humble")
    if bag.suffix == ".bag":  # which holds the definitions of its messages
        assert "rosbag1.types: no such option" in reported
    else:
        assert "types: no release 'humble'; did you mean 'ros2_humble'?" in reported


@pytest.mark.parametrize("name", ["log.mcap", "log.db3", "log.bag"])
@pytest.mark.parametrize("keep", [0.0, 0.2, 0.6, 0.98])
def test_a_cut_off_file_is_refused(tmp_path: Path, name: str, keep: float) -> None:
    path = write_bag(tmp_path / name, {"/ft": topics()["/ft"]})
    content = path.read_bytes()
    path.write_bytes(content[: int(keep * len(content))])
    assert "raw/log: no whole bag (" in fault(path, WantedColumns(("wrench.force.x",)))


@pytest.mark.parametrize("name", ["log.mcap", "log.bag"])
def test_a_bag_without_topics_is_an_empty_file(tmp_path: Path, name: str) -> None:
    path = write_bag(tmp_path / name, {})
    with pytest.raises(InputError) as caught:
        read(path, WantedColumns(("x",)))
    assert [entry.code for entry in caught.value.faults] == [FaultCode.FILE_EMPTY]


def test_a_message_without_the_joint_is_placed(tmp_path: Path) -> None:
    messages = [
        (MOMENTS[0], joint_state(MOMENTS[0], FIRST, ANGLES[0])),
        (MOMENTS[1], joint_state(MOMENTS[1], ["A1"], [1.0])),
    ]
    path = write_bag(tmp_path / "log.mcap", {"/joint_states": messages})
    assert "topic /joint_states, message 2: it has no 'position.arm.2'" in fault(
        path, WantedColumns(("position.arm.2",))
    )


def test_both_formats_are_listed() -> None:
    assert {"mcap", "rosbag1", "rosbag2", "tdms", "mat"} <= set(format_names())
    assert find_reader(Path("x"), "mcap").name == "mcap"


def test_a_bag_of_ros1_whose_recording_was_interrupted_has_no_index(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "log.bag", {"/ft": topics()["/ft"]})
    content = path.read_bytes()
    at = content.index(b"index_pos=") + len(b"index_pos=")
    path.write_bytes(content[:at] + bytes(8) + content[at + 8 :])
    reported = fault(path, WantedColumns(("wrench.force.x",)))
    assert "[file-damaged]" in reported
    assert "rosbag reindex" in reported


def test_a_bag_of_ros1_that_lists_a_message_twice_is_refused(tmp_path: Path) -> None:
    """As one could be read any number of times."""
    path = write_bag(tmp_path / "log.bag", {"/ft": topics()["/ft"][:3]})
    content = path.read_bytes()
    first, second = (struct.pack("<LL", *divmod(moment + 7, 1_000_000_000)) for moment in MOMENTS[:2])
    entries = re.search(re.escape(first) + b"(.{4})" + re.escape(second) + b".{4}", content, re.DOTALL)
    assert entries is not None
    path.write_bytes(content[: entries.end() - 12] + first + entries[1] + content[entries.end() :])
    assert "lists a message twice" in fault(path, WantedColumns(("wrench.force.x",)))
