"""Writes small bags for tests: a folder of ROS 2, a file inside it, an MCAP file, or a bag of ROS 1."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
T: dict[str, Any] = STORE.types
ROS1 = get_typestore(Stores.ROS1_NOETIC)
ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))


def write_bag(path: Path, topics: Mapping[str, Iterable[tuple[int, Any]]]) -> Path:
    """Write (ns, message) of each topic to `path`: an ``.mcap``, ``.db3`` or ``.bag`` file, or else a folder."""
    if path.suffix == ".bag":
        return _write_ros1_bag(path, topics)
    folder = path.with_name(path.name + "-bag") if path.suffix else path
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        for topic, messages in topics.items():
            connection = None
            for moment, message in messages:
                if connection is None:
                    connection = writer.add_connection(topic, message.__msgtype__, typestore=STORE)
                writer.write(connection, moment, STORE.serialize_cdr(message, message.__msgtype__))
    if path.suffix:
        (inside,) = folder.glob(f"*{path.suffix}")
        shutil.move(inside, path)
        shutil.rmtree(folder)
    return path


def _write_ros1_bag(path: Path, topics: Mapping[str, Iterable[tuple[int, Any]]]) -> Path:
    with Ros1Writer(path) as writer:
        for topic, messages in topics.items():
            connection = None
            for moment, message in messages:
                if connection is None:
                    connection = writer.add_connection(topic, message.__msgtype__, typestore=ROS1)
                writer.write(connection, moment, ROS1.serialize_ros1(as_ros1(message), message.__msgtype__))
    return path


def as_ros1(item: Any) -> Any:
    """Return a message of ROS 2 as ROS 1 has it, whose headers count."""
    if isinstance(item, list):
        return [as_ros1(element) for element in item]
    if not is_dataclass(item):
        return item
    values = {field.name: as_ros1(getattr(item, field.name)) for field in fields(item) if field.init}
    kind = str(getattr(item, "__msgtype__"))  # noqa: B009
    return ROS1.types[kind](**values, **({"seq": 0} if kind == "std_msgs/msg/Header" else {}))


def header(moment: int, frame: str = "base") -> Any:
    stamp = T["builtin_interfaces/msg/Time"](sec=moment // 1_000_000_000, nanosec=moment % 1_000_000_000)
    return T["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def vector(values: Iterable[float], kind: str = "Vector3") -> Any:
    return T[f"geometry_msgs/msg/{kind}"](*(float(value) for value in values))


def wrench(moment: int, values: Any) -> Any:
    inside = T["geometry_msgs/msg/Wrench"](force=vector(values[:3]), torque=vector(values[3:]))
    return T["geometry_msgs/msg/WrenchStamped"](header=header(moment), wrench=inside)


def pose(moment: int, position: Any, quaternion_wxyz: Any) -> Any:
    w, x, y, z = quaternion_wxyz
    orientation = vector((x, y, z, w), "Quaternion")
    inside = T["geometry_msgs/msg/Pose"](position=vector(position, "Point"), orientation=orientation)
    return T["geometry_msgs/msg/PoseStamped"](header=header(moment), pose=inside)


def joint_state(moment: int, names: list[str], values: Any) -> Any:
    empty = np.zeros(0)
    return T["sensor_msgs/msg/JointState"](
        header=header(moment), name=names, position=np.array(values, dtype=float), velocity=empty, effort=empty
    )


def transforms(moment: int, placed: dict[str, Any]) -> Any:
    turn = vector((0.0, 0.0, 0.0, 1.0), "Quaternion")
    held = [
        T["geometry_msgs/msg/TransformStamped"](
            header=header(moment),
            child_frame_id=child,
            transform=T["geometry_msgs/msg/Transform"](translation=vector(place), rotation=turn),
        )
        for child, place in placed.items()
    ]
    return T["tf2_msgs/msg/TFMessage"](transforms=held)
