"""ROS 2 bags (folders, ``.db3``) and MCAP files, read without any ROS. Needs the extra ``ros`` (rosbags).

Options of the manifest (``rosbag2 = {…}``, ``mcap = {…}``), all optional:

topic : the topic that is read; may be left out where the bag has only one.
child_frame : of ``tf2_msgs/TFMessage``: the frame whose transforms are the rows.
types : where the bag holds no definitions of its messages: the ROS release whose they are, ``ros2_humble`` when absent.

Each message is a row. A column is a field, by its path: ``wrench.force.x``, ``pose.position.z``, ``header.stamp`` (in
seconds), an element of an array ``data[0]``, and where a message names its elements (``sensor_msgs/JointState``) by
that name: ``position.A1``, in whatever order the message lists them. ``time`` is when the message was recorded, in
seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.campaign.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import COLUMNS, ROWS, check_unpacked
from stiffcal.readers import (
    Batch,
    Header,
    Options,
    Reader,
    WantedColumns,
    batch_of_columns,
    check_columns,
    check_options,
    damaged_file_errors,
    missing_library,
    nearest_name,
)
from stiffcal.readers.rosbag2.definitions import checked_types, parsed_types
from stiffcal.readers.rosbag2.fuzz_inputs import fuzz_input
from stiffcal.readers.rosbag2.storage import CHUNK, MESSAGE, QuotedPath, check_bag, check_chunks, fence_rosbags, unzstd

BATCH_MESSAGES = 1 << 14
RECORDED = "time"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
# Arrays of a joint state, whose elements go by the names in `name`.
NAMED = ("position", "velocity", "effort")
MEND = "copy it again from its origin; `mcap recover` or `ros2 bag reindex` may repair an incomplete recording"
UNKNOWN_AT_END = "ros2_humble"


class RosOptions(TomlTable):
    """Which messages of a ROS 2 bag or MCAP file are read; its columns are fields: ``wrench.force.x``, ``position.A1``.

    Attributes
    ----------
    topic : may be left out where the bag has only one. child_frame : of transforms, the frame that was tracked.
    types : the ROS release (``ros2_humble``) whose messages they are, where the bag does not define them itself.
    """

    topic: Name | None = None
    child_frame: Name | None = None
    types: Name | None = None


class RosReader(Reader):
    """Reads one topic of a bag in batches of messages; `stiffcal.readers.mcap` reads MCAP files in the same way."""

    name = "rosbag2"
    endings = (".db3",)
    options = RosOptions
    fuzz_inputs = (fuzz_input(".db3", "SQLITE3"),)

    def recognises(self, path: Path) -> bool:
        """Return True for a bag's folder, or a file named like one inside."""
        return path.suffix.lower() in self.endings or (path / "metadata.yaml").is_file()

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the fields of the topic's first message."""
        display_name = display_name or str(path)
        with self._open(path, options, display_name) as topic:
            columns = topic.columns()
            if wanted is not None:
                check_columns(wanted, columns, display_name, f"topic {topic.name}")
            units = {name: "s" for name in columns if name == RECORDED or name.split(".")[-1] == "stamp"}
            return Header(columns, units, topic.n_messages if topic.child_frame is None else None)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the messages in batches.

        Raises
        ------
        InputError
            For a damaged or cut off bag, a topic or field that is not there, a message without one of the joints.
        """
        display_name = display_name or str(path)
        with self._open(path, options, display_name) as topic:
            check_columns(wanted, topic.columns(), display_name, f"topic {topic.name}")
            takers = {name: _taker(name) for name in wanted.names}
            values: dict[str, list[Any]] = {name: [] for name in wanted.names}
            start = n_held = 0
            for recorded, message in topic.messages():
                for name, take in takers.items():
                    try:
                        values[name].append(take(recorded, message))
                    except (ValueError, IndexError, AttributeError, TypeError):
                        place = f"topic {topic.name}, message {start + n_held + 1}"
                        mend = "exclude the file, or write a copy without such messages"
                        raise InputError.at(
                            FaultCode.LOG_PART_MISSING, display_name, place, f"it has no {name!r}", mend
                        ) from None
                n_held += 1
                ROWS.check(start + n_held, display_name, f"topic {topic.name}")
                if n_held == BATCH_MESSAGES:
                    yield _batch(values, wanted, start, n_held, display_name)
                    values, start, n_held = {name: [] for name in wanted.names}, start + n_held, 0
            if n_held:
                yield _batch(values, wanted, start, n_held, display_name)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``message n``."""
        return f"message {row}"

    @contextmanager
    def _open(self, path: Path, options: Options, display_name: str) -> Iterator[_Topic]:
        check_options(options, RosOptions, self.name, display_name)
        if not path.exists():
            raise InputError.at(FaultCode.FILE_MISSING, display_name, "", "no such file", "correct the file's name")
        try:
            from rosbags.rosbag2 import Reader
            from rosbags.typesys import Stores
        except ImportError:
            raise missing_library(self.name, display_name, "ros") from None
        releases = [store.value for store in Stores if store.value.startswith("ros2_")]
        types = str(options.get("types") or UNKNOWN_AT_END)
        if types not in releases:
            raise InputError.at(
                FaultCode.OPTION_INVALID,
                display_name,
                f"{self.name}.types",
                f"no release {types!r}",
                nearest_name(types, releases),
            )
        fence_rosbags()
        with damaged_file_errors("bag", display_name, MEND):
            check_bag(path, display_name)
            with Reader(QuotedPath(path)) as reader:
                check_chunks(reader, path, display_name)
                try:
                    yield _topic(reader, self.name, {**options, "types": types}, display_name)
                except InputError as error:  # what unpacks a part of the bag does not know its name
                    faults = (
                        replace(fault, file=display_name, place=fault.file) if fault.file in (CHUNK, MESSAGE) else fault
                        for fault in error.faults
                    )
                    raise InputError(*faults) from None


READER = RosReader()


@dataclass(frozen=True)
class _Topic:
    """One topic of an open bag, and how its messages are read."""

    bag: Any
    types: Any
    packed: bool
    connections: list[Any]
    child_frame: str | None
    display_name: str
    option: str

    @property
    def name(self) -> str:
        return str(self.connections[0].topic)

    @property
    def n_messages(self) -> int:
        return sum(connection.msgcount for connection in self.connections)

    def messages(self) -> Iterator[tuple[int, Any]]:
        """Yield (recorded ns, message); of transforms those of the child frame."""
        child_frames: set[str] = set()
        any_match = False
        packed = unpacked = 0
        for connection, recorded, raw in self.bag.messages(connections=self.connections):
            if self.packed:
                packed, raw = packed + len(raw), unzstd(raw)
                unpacked += len(raw)
                check_unpacked(unpacked, packed, self.display_name, f"topic {self.name}")
            message = self.types.deserialize_cdr(raw, connection.msgtype)
            if self.child_frame is None:
                yield recorded, message
                continue
            for transform in message.transforms:
                if transform.child_frame_id == self.child_frame:
                    any_match = True
                    yield recorded, transform
                elif len(child_frames) < 100:
                    child_frames.add(transform.child_frame_id)
        if self.child_frame is not None and not any_match:
            reason = f"no transform of frame {self.child_frame!r} in {self.name}"
            mend = nearest_name(self.child_frame, sorted(child_frames), "there are")
            raise InputError.at(
                FaultCode.LOG_PART_MISSING, self.display_name, f"{self.option}.child_frame", reason, mend
            )

    def columns(self) -> tuple[str, ...]:
        """Return the columns of the first message."""
        for _, message in self.messages():
            columns = tuple(islice(_paths(message, ""), COLUMNS.most + 1))
            COLUMNS.check(len(columns), self.display_name, f"topic {self.name}")
            return (RECORDED, *columns)
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            self.display_name,
            f"topic {self.name}",
            "it has no messages",
            "log again, or exclude the file",
        )


def _topic(bag: Any, option: str, options: Options, display_name: str) -> _Topic:
    topics = sorted({connection.topic for connection in bag.connections})
    requested = options.get("topic")
    if requested is None and len(topics) != 1:
        listed = ", ".join(f"{name} ({bag.topics[name].msgtype})" for name in topics[:12]) or "none"
        reason = f"the bag contains {len(topics)} topics"
        raise InputError.at(
            FaultCode.LOG_PART_AMBIGUOUS, display_name, f"{option}.topic", reason, f"state which: {listed}"
        )
    name = str(requested) if requested is not None else topics[0]
    connections = [connection for connection in bag.connections if connection.topic == name]
    if not connections:
        raise InputError.at(
            FaultCode.LOG_PART_MISSING,
            display_name,
            f"{option}.topic",
            f"no topic {name!r}",
            nearest_name(name, topics),
        )
    child = options.get("child_frame")
    transforms = connections[0].msgtype == TRANSFORMS
    if transforms and child is None:
        mend = f'add {option}.child_frame = "…", the frame that was tracked'
        raise InputError.at(
            FaultCode.LOG_PART_AMBIGUOUS,
            display_name,
            f"topic {name}",
            "its messages contain transforms of several frames",
            mend,
        )
    types = _type_store(bag, connections, str(options["types"]), display_name)
    storage = bag.storage
    packed = storage.metadata.compression_mode == "message"
    if packed:  # unpacked here, within bounds
        storage.metadata = storage.metadata._replace(compression_mode=None)
    return _Topic(bag, types, packed, connections, str(child) if transforms else None, display_name, option)


def _type_store(bag: Any, connections: list[Any], release: str, display_name: str) -> Any:
    """Return the decoder of some connections' messages: by the bag's own definitions, else by those of a release."""
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import Stores, get_typestore

    if all(connection.msgdef.format == MessageDefinitionFormat.NONE for connection in bag.connections):
        return get_typestore(Stores(release))
    types = parsed_types(connections, display_name)
    if any(connection.msgtype not in types for connection in connections):
        types = parsed_types(bag.connections, display_name)
    store = get_typestore(Stores.EMPTY)
    for connection in connections:
        store.register(checked_types(types, connection.msgtype, display_name))
        if connection.digest and store.hash_rihs01(connection.msgtype) != connection.digest:
            raise InputError.at(
                FaultCode.CONTENT_UNSUPPORTED,
                display_name,
                f"message type {connection.msgtype}",
                "its definition is of another version",
                MEND,
            )
    return store


def _paths(item: Any, path: str) -> Iterator[str]:
    """Yield the path of every number and word in a message."""
    names = list(getattr(item, "name", ())) if not isinstance(getattr(item, "name", ""), str) else []
    for field in fields(item):
        value = getattr(item, field.name)
        field_path = f"{path}{field.name}"
        if field.name.startswith("__"):
            continue
        if is_dataclass(value):
            if _is_time(value):
                yield field_path
            else:
                yield from _paths(value, f"{field_path}.")
        elif isinstance(value, np.ndarray | list | tuple):
            if field.name in NAMED and names and len(value) == len(names):
                yield from (f"{field_path}.{name}" for name in names)
                continue
            for index, element in enumerate(value):
                if is_dataclass(element):
                    yield from _paths(element, f"{field_path}[{index}].")
                elif isinstance(element, int | float | str | np.generic):
                    yield f"{field_path}[{index}]"
        elif isinstance(value, int | float | str | np.generic):
            yield field_path


def _seconds(value: Any) -> float:
    return float(value.sec + value.nanosec * 1e-9)


def _is_time(value: Any) -> bool:
    return {"sec", "nanosec"} <= {field.name for field in fields(value)}


def _taker(column: str) -> Callable[[int, Any], Any]:
    """Return the function that takes a column's value out of (recorded, message)."""
    if column == RECORDED:
        return lambda recorded, message: recorded * 1e-9
    # A joint's name may hold points itself, and the order of the names may change between messages.
    pieces = column.split(".")
    place = next((k for k, name in enumerate(pieces[:-1]) if name in NAMED), None)
    if place is None:
        return _by_path(pieces)
    by_name = _by_name(pieces[: place + 1], ".".join(pieces[place + 1 :]))
    by_path = _by_path(pieces)
    inside = _steps(pieces[: place + 1])

    def take(recorded: int, message: Any) -> Any:
        # `position` is an array in a joint's state, three members in a pose.
        value = message
        for step in inside:
            value = step(value)
        return (by_path if is_dataclass(value) else by_name)(recorded, message)

    return take


def _by_path(parts: list[str]) -> Callable[[int, Any], Any]:
    steps = _steps(parts)

    def take(_: int, message: Any) -> Any:
        for step in steps:
            message = step(message)
        return _seconds(message) if is_dataclass(message) else message

    return take


def _by_name(parts: list[str], joint: str) -> Callable[[int, Any], Any]:
    steps, array = _steps(parts[:-1]), parts[-1]

    def take(_: int, message: Any) -> Any:
        for step in steps:
            message = step(message)
        return getattr(message, array)[list(message.name).index(joint)]

    return take


def _steps(parts: list[str]) -> list[Callable[[Any], Any]]:
    return [_step(piece) for joined in parts for piece in joined.replace("[", ".[").split(".")]


def _step(piece: str) -> Callable[[Any], Any]:
    if piece.startswith("["):
        index = int(piece[1:-1])
        return lambda item: item[index]
    return lambda item: getattr(item, piece)


def _batch(values_of: dict[str, list[Any]], wanted: WantedColumns, start: int, count: int, display_name: str) -> Batch:
    arrays = {name: np.asarray(values) for name, values in values_of.items()}
    return batch_of_columns(lambda name, a, b: arrays[name], wanted, start, start + count, display_name)
