"""Small bags of one topic of wrenches, for tests of hostile input."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from stiffcal.readers import FuzzInput

START_NS, STEP_NS = 1_795_248_930_000_000_000, 2_000_000
KIND = "geometry_msgs/msg/WrenchStamped"


def fuzz_input(ending: str, plugin: str) -> FuzzInput:
    """Return a bag's file, ``.db3`` or ``.mcap``; `plugin`: rosbags' name of its storage."""

    def write(path: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_HUMBLE)
        folder = path.with_name(path.name + "-bag")
        with Writer(folder, version=9, storage_plugin=StoragePlugin[plugin]) as writer:
            connection = writer.add_connection("/ft", KIND, typestore=store)
            for moment, message in _messages(store):
                writer.write(connection, moment, store.serialize_cdr(message, KIND))
        (inside,) = folder.glob(f"*{ending}")
        shutil.move(inside, path)
        shutil.rmtree(folder)

    return _fuzz_input(ending, write)


def fuzz_input_ros1() -> FuzzInput:
    """Return a bag of ROS 1."""

    def write(path: Path) -> None:
        from rosbags.rosbag1 import Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS1_NOETIC)
        path.unlink(missing_ok=True)
        with Writer(path) as writer:
            connection = writer.add_connection("/ft", KIND, typestore=store)
            for moment, message in _messages(store, seq=0):
                writer.write(connection, moment, store.serialize_ros1(message, KIND))

    return _fuzz_input(".bag", write)


def _fuzz_input(ending: str, write: Callable[[Path], None]) -> FuzzInput:
    return FuzzInput(ending, write, ("time", "wrench.force.x"), ("header.frame_id",), {"topic": "/ft"})


def _messages(store: Any, **of_header: int) -> Iterator[tuple[int, Any]]:
    """Yield (recorded ns, message); `of_header`: what the release's header has besides."""
    types = store.types
    vector, zero = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    for k in range(60):
        moment = START_NS + k * STEP_NS
        seconds, nanoseconds = divmod(moment, 1_000_000_000)
        stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="base", **of_header)
        wrench = types["geometry_msgs/msg/Wrench"](force=vector(k - 30.5, 0.0, 0.0), torque=zero)
        yield moment, types[KIND](header=header, wrench=wrench)
