"""Small bags of one topic of wrenches, for tests of hostile input."""

from __future__ import annotations

import shutil
from pathlib import Path

from stiffcal.readers import FuzzInput

START_NS, STEP_NS = 1_795_248_930_000_000_000, 2_000_000


def fuzz_input(ending: str, plugin: str) -> FuzzInput:
    """Return a bag's file, ``.db3`` or ``.mcap``; `plugin`: rosbags' name of its storage."""

    def write(path: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_HUMBLE)
        types = store.types
        vector, zero = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
        kind = "geometry_msgs/msg/WrenchStamped"
        folder = path.with_name(path.name + "-bag")
        with Writer(folder, version=9, storage_plugin=StoragePlugin[plugin]) as writer:
            connection = writer.add_connection("/ft", kind, typestore=store)
            for k in range(60):
                seconds, nanoseconds = divmod(START_NS + k * STEP_NS, 1_000_000_000)
                stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
                header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="base")
                wrench = types["geometry_msgs/msg/Wrench"](force=vector(k - 30.5, 0.0, 0.0), torque=zero)
                message = types[kind](header=header, wrench=wrench)
                writer.write(connection, START_NS + k * STEP_NS, store.serialize_cdr(message, kind))
        (inside,) = folder.glob(f"*{ending}")
        shutil.move(inside, path)
        shutil.rmtree(folder)

    return FuzzInput(ending, write, ("time", "wrench.force.x"), ("header.frame_id",), {"topic": "/ft"})
