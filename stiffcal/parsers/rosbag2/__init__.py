"""Bags of ROS 2 and ROS 1, and MCAP files: each message of a topic is a row, each field a column."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import (
    Batch,
    Options,
    WantedColumns,
    batch_of_columns,
    damaged_file_errors,
    missing_library,
    nearest_name,
)
from stiffcal.parsers.open_log import OpenLog
from stiffcal.parsers.rosbag2.columns import RECORDED, paths_of, taker
from stiffcal.parsers.rosbag2.definitions import checked_types, parsed_types
from stiffcal.parsers.rosbag2.storage import QuotedPath, check_bag, checked_chunks, checked_ros1_chunks

LIBRARIES = ("rosbags.rosbag1", "rosbags.rosbag2", "rosbags.typesys")
"""Imported before the limits of a log hold."""
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
MEND = "copy it again from its origin; `mcap recover` or `ros2 bag reindex` may repair an incomplete recording"
MEND_ROS1 = "copy it again from its origin; `rosbag reindex` may repair an incomplete recording"
UNKNOWN_AT_END = "ros2_humble"


class OpenBag(OpenLog):
    """A topic of an open bag."""

    BATCH_BYTES: ClassVar[int] = 64 << 20
    """Bytes of messages that are read for a batch, at most: what they unpack to is checked after it."""

    def __init__(self, topic: _Topic, display_name: str, unpacked: int) -> None:
        self.columns = topic.columns()
        self.units = {name: "s" for name in self.columns if name == RECORDED or name.split(".")[-1] == "stamp"}
        self.n_rows = topic.n_messages if topic.child_frame is None else None
        self.display_name, self.place = display_name, f"topic {topic.name}"
        self.unpacked = unpacked
        self._topic = topic

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the messages in batches.

        Raises
        ------
        InputError
            For a damaged or cut off bag, a message without one of the fields or joints.
        """
        takers = {name: taker(name) for name in wanted.names}
        values: dict[str, list[Any]] = {name: [] for name in wanted.names}
        start = n_held = n_bytes = n_read = 0
        for recorded, message, size in self._topic.messages():
            n_bytes, n_read = n_bytes + size, n_read + size
            self.unpacked = max(self.unpacked, n_read)  # a chunk may state less than it holds
            for name, take in takers.items():
                try:
                    values[name].append(take(recorded, message))
                except (ValueError, IndexError, AttributeError, TypeError):
                    place = f"{self.place}, message {start + n_held + 1}"
                    mend = "exclude the file, or write a copy without such messages"
                    raise InputError.at(
                        FaultCode.LOG_PART_MISSING, self.display_name, place, f"it has no {name!r}", mend
                    ) from None
            n_held += 1
            if n_held == self.BATCH_ROWS or n_bytes > self.BATCH_BYTES:
                yield _batch(values, wanted, start, n_held, self.display_name)
                values, start = {name: [] for name in wanted.names}, start + n_held
                n_held = n_bytes = 0
        if n_held:
            yield _batch(values, wanted, start, n_held, self.display_name)


def open_log(path: Path, options: Options, display_name: str) -> AbstractContextManager[OpenBag]:
    """Open a topic of a bag; the parameters and errors are those of `open_bag`."""
    return open_bag(path, options, display_name, "rosbag2")


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each topic of a bag; the errors are those of `open_bag`."""
    with _ros2_bag(path, display_name, "rosbag2") as bag:
        return bag.tables()


@contextmanager
def open_bag(path: Path, options: Options, display_name: str, option: str) -> Iterator[OpenBag]:
    """Open a topic of a bag.

    Parameters
    ----------
    path : of a file or folder. options : checked. display_name : how to call it in a fault.
    option : the name of the options in the manifest.

    Raises
    ------
    InputError
        For a damaged bag, a topic or release that is not there.
    """
    with _ros2_bag(path, display_name, option) as bag:
        yield OpenBag(bag.topic(options), display_name, bag.unpacked)


@contextmanager
def open_ros1_bag(path: Path, options: Options, display_name: str, option: str) -> Iterator[OpenBag]:
    """Open a topic of a bag of ROS 1, which holds the definitions of its messages; else as `open_bag`."""
    with _ros1_bag(path, display_name, option) as bag:
        yield OpenBag(bag.topic(options), display_name, bag.unpacked)


def ros1_tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each topic of a bag of ROS 1; the errors are those of `open_bag`."""
    with _ros1_bag(path, display_name, "rosbag1") as bag:
        return bag.tables()


# Of transforms so many messages show which frames were tracked.
_TRANSFORMS_LOOKED_AT = 1000


@dataclass(frozen=True)
class _Bag:
    """An open bag.

    Attributes
    ----------
    reader : of the library. decoder : returns what decodes the messages of some connections, by the options.
    unpacked : bytes that it unpacks to. option : the name of the options in the manifest.
    """

    reader: Any
    decoder: Callable[[list[Any], Options], Callable[[bytes, str], Any]]
    unpacked: int
    display_name: str
    option: str

    def topic(self, options: Options) -> _Topic:
        """Return the topic that the options name, or the only one."""
        connections = _connections(self.reader, self.option, options, self.display_name)
        return self._topic(connections, options)

    def tables(self) -> list[Options]:
        """Return the options that choose each topic, of transforms each frame that was tracked."""
        found: list[Options] = []
        for name in sorted({connection.topic for connection in self.reader.connections}):
            connections = [connection for connection in self.reader.connections if connection.topic == name]
            if connections[0].msgtype not in TRANSFORMS:
                found.append({"topic": name})
                continue
            messages = islice(self._topic(connections, {}).decoded(), _TRANSFORMS_LOOKED_AT)
            frames = {str(one.child_frame_id): None for _, message, _ in messages for one in message.transforms}
            found += [{"topic": name, "child_frame": frame} for frame in frames]
        return [{}] if len(found) == 1 and len(found[0]) == 1 else found

    def _topic(self, connections: list[Any], options: Options) -> _Topic:
        decode = self.decoder(connections, options)
        return _Topic(self.reader, decode, connections, options, self.display_name, self.option)


@contextmanager
def _ros2_bag(path: Path, display_name: str, option: str) -> Iterator[_Bag]:
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores
    except ImportError:
        raise missing_library(option, display_name, "ros") from None
    releases = [store.value for store in Stores if store.value.startswith("ros2_")]

    def decoder(connections: list[Any], options: Options) -> Callable[[bytes, str], Any]:
        types = str(options.get("types") or UNKNOWN_AT_END)
        if types not in releases:
            place, near = f"{option}.types", nearest_name(types, releases)
            raise InputError.at(FaultCode.OPTION_INVALID, display_name, place, f"no release {types!r}", near)
        decode: Callable[[bytes, str], Any] = _type_store(bag, connections, types, display_name).deserialize_cdr
        return decode

    with damaged_file_errors("bag", display_name, MEND):
        check_bag(path, display_name)
        with Reader(QuotedPath(path)) as bag:
            yield _Bag(bag, decoder, checked_chunks(bag, display_name), display_name, option)


@contextmanager
def _ros1_bag(path: Path, display_name: str, option: str) -> Iterator[_Bag]:
    try:
        from rosbags.rosbag1 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_library(option, display_name, "ros") from None

    def decoder(connections: list[Any], _: Options) -> Callable[[bytes, str], Any]:
        store = get_typestore(Stores.EMPTY)
        types = store.fielddefs | parsed_types(connections, display_name)  # times are of no definition in ROS 1
        store.register(checked_types(types, connections[0].msgtype, display_name))
        decode: Callable[[bytes, str], Any] = store.deserialize_ros1
        return decode

    with damaged_file_errors("bag", display_name, MEND_ROS1), Reader(path) as bag:
        unpacked = checked_ros1_chunks(bag, path.stat().st_size, display_name)
        yield _Bag(bag, decoder, unpacked, display_name, option)


@dataclass(frozen=True)
class _Topic:
    """One topic of an open bag, and how its messages are read."""

    bag: Any
    decode: Callable[[bytes, str], Any]
    connections: list[Any]
    options: Options
    display_name: str
    option: str

    @property
    def child_frame(self) -> str | None:
        """The frame whose transforms are read; None of other messages."""
        return str(self.options["child_frame"]) if self.connections[0].msgtype in TRANSFORMS else None

    @property
    def name(self) -> str:
        return str(self.connections[0].topic)

    @property
    def n_messages(self) -> int:
        return sum(connection.msgcount for connection in self.connections)

    def messages(self) -> Iterator[tuple[int, Any, int]]:
        """Yield (recorded ns, message, bytes that were read for it); of transforms those of the child frame."""
        if self.child_frame is None:
            yield from self.decoded()
            return
        child_frames: set[str] = set()
        any_match, size = False, 0
        for recorded, message, n_bytes in self.decoded():
            size += n_bytes
            for transform in message.transforms:
                if transform.child_frame_id == self.child_frame:
                    any_match = True
                    yield recorded, transform, size
                    size = 0
                elif len(child_frames) < 100:
                    child_frames.add(transform.child_frame_id)
        if not any_match:
            reason = f"no transform of frame {self.child_frame!r} in {self.name}"
            mend = nearest_name(self.child_frame, sorted(child_frames), "there are")
            raise InputError.at(
                FaultCode.LOG_PART_MISSING, self.display_name, f"{self.option}.child_frame", reason, mend
            )

    def decoded(self) -> Iterator[tuple[int, Any, int]]:
        """Yield (recorded ns, message, its bytes) of every message."""
        for connection, recorded, raw in self.bag.messages(connections=self.connections):
            yield recorded, self.decode(raw, connection.msgtype), len(raw)

    def columns(self) -> tuple[str, ...]:
        """Return the columns of the first message."""
        for _, message, _ in self.messages():
            return (RECORDED, *paths_of(message, ""))
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            self.display_name,
            f"topic {self.name}",
            "it has no messages",
            "log again, or exclude the file",
        )


def _connections(bag: Any, option: str, options: Options, display_name: str) -> list[Any]:
    """Return the connections of the topic that the options name, or of the only one."""
    topics = sorted({connection.topic for connection in bag.connections})
    requested = options.get("topic")
    if not topics:
        raise InputError.at(
            FaultCode.FILE_EMPTY, display_name, "", "the bag contains no topics", "log again, or leave the file out"
        )
    if requested is None and len(topics) != 1:
        listed = ", ".join(f"{name} ({bag.topics[name].msgtype})" for name in topics[:12])
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
    if connections[0].msgtype in TRANSFORMS and options.get("child_frame") is None:
        mend = f'add {option}.child_frame = "…", the frame that was tracked'
        raise InputError.at(
            FaultCode.LOG_PART_AMBIGUOUS,
            display_name,
            f"topic {name}",
            "its messages contain transforms of several frames",
            mend,
        )
    return connections


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


def _batch(values_of: dict[str, list[Any]], wanted: WantedColumns, start: int, count: int, display_name: str) -> Batch:
    arrays = {name: np.asarray(values) for name, values in values_of.items()}
    return batch_of_columns(lambda name, a, b: arrays[name], wanted, start, start + count, display_name)
