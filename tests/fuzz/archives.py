"""Archives that unpack to far more than their bytes, of every log format that packs, whole or spoilt.

The limits are lowered for the while, so that small archives exceed them, and thousands can be made in minutes. A whole
archive beyond the limits must be refused; whatever is spoilt ends in one line or is read.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import math
import os
import random
import shutil
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pyarrow as pa

from stiffcal.readers import WantedColumns, find_reader
from tests.fuzz.mutations import spoilt_bytes

RATIO, RATIO_FROM, PIECE = 20, 1 << 16, 4 << 20
"""The lowered limits: unpacked bytes for each packed one, from how many on, and bytes to be held at once."""

LINES = (b"0,0,0\n", b"\n", b"\0", b'"', b"0,", b" ", b"1,2,3,4\n", b"0.25,-1e-3,7\n", b"#\n", b"\r", b"nan,,\n", b"9")
PACKERS: dict[str, Callable[[bytes], bytes]] = {
    ".gz": lambda content: gzip.compress(content, 9),
    ".bz2": lambda content: bz2.compress(content, 1),
    ".xz": lzma.compress,
    ".zst": lambda content: bytes(pa.compress(content, "zstd", asbytes=True)),
}
Made = tuple[str, dict[str, object], int]
"""Format, options of the manifest, and the bytes that the file unpacks to; 0 where nobody can say."""


BAGS = {".mcap": "mcap", ".db3": "rosbag2", ".bag": "rosbag1"}


class NotRefusedError(AssertionError):
    """What had to be refused went through."""


def feed_bomb(chance: random.Random, folder: Path) -> None:
    """Make an archive, mostly beyond the limits, and read it."""
    place = folder / "archive"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    ending, make = chance.choice(MAKERS)
    path = place / f"log{ending}"
    log_format, options, unpacked = make(chance, path)
    path = next(place.iterdir())
    packed = path.stat().st_size if path.is_file() else sum(part.stat().st_size for part in path.iterdir())
    if path.is_file() and chance.random() < 0.3:
        path.write_bytes(spoilt_bytes(chance, path.read_bytes()))
        unpacked = 0
    names = ("wrench.force.x", "header.frame_id") if log_format in BAGS.values() else ("t", "Fx")
    wanted = WantedColumns(names[:1], names[1:]) if log_format in BAGS.values() else WantedColumns(names)
    with lowered_limits():
        for _ in find_reader(path, log_format, "raw/log").read_batches(path, options, wanted, "raw/log"):
            pass
    if unpacked > RATIO_FROM and unpacked > RATIO * packed:
        raise NotRefusedError(f"{path.name}: {packed} bytes unpacked to {unpacked}")


@contextmanager
def lowered_limits() -> Iterator[None]:
    """Lower the limits so that a small archive exceeds them."""
    from stiffcal import limits

    environment = {"STIFFCAL_MAX_RATIO": str(RATIO), "STIFFCAL_MAX_PIECE": str(PIECE)}
    with mock.patch.object(limits, "RATIO_FROM", RATIO_FROM), mock.patch.dict(os.environ, environment):
        yield


def make_text(chance: random.Random, path: Path) -> Made:
    """Write packed text: many equal lines after some that are not, in one member or several, packed once or twice."""
    head = b"t,Fx,Fy\n" + b"".join(
        b"%d,%r,0\n" % (row, chance.random()) for row in range(chance.choice((0, 1, 9, 300)))
    )
    line = chance.choice(LINES)
    content = head + line * (int(10 ** chance.uniform(3.0, 5.7)) // len(line))
    ending, pack = chance.choice(tuple(PACKERS.items()))
    members = chance.choice((1, 1, 1, 2, 3))
    packed = pack(content) + b"".join(pack(line * (len(content) // len(line))) for _ in range(members - 1))
    unpacked = members * len(content)
    if chance.random() < 0.1:
        packed, unpacked = PACKERS[ending](packed), 0
    if chance.random() < 0.1:
        ending, unpacked = chance.choice((*PACKERS, "")), 0
    path.with_name(f"log.csv{ending}").write_bytes(packed)
    # of some lines a cell is refused before the limit is reached: that is a refusal as well
    return "csv", {}, unpacked


def _rows(chance: random.Random) -> int:
    return int(10 ** chance.uniform(2.0, 4.9))


def make_hdf5(chance: random.Random, path: Path, log_format: str = "hdf5") -> Made:
    """Write columns of equal numbers in packed chunks, columns that claim more than they hold, or an odd chunk."""
    import h5py

    unpacked = 0
    with h5py.File(path, "w", userblock_size=512 if log_format == "mat" else 0) as file:
        rows = _rows(chance) if chance.random() < 0.7 else int(10 ** chance.uniform(5.0, 17.0))
        shape: tuple[int, ...] = (1, rows) if log_format == "mat" else (rows,)
        for name in ("t", "Fx"):
            chunk = min(rows, int(10 ** chance.uniform(1.0, 6.5)))
            chunks = (1, chunk) if log_format == "mat" else (chunk,)
            stored: Mapping[str, Any] = chance.choice(
                ({"compression": "gzip"}, {"compression": "gzip", "shuffle": True}, {"compression": "lzf"}, {})
            )
            data = file.create_dataset(name, shape, "f8", chunks=chunks, fillvalue=chance.choice((0.0, 1.0)), **stored)
            if rows < 10**5 and chance.random() < 0.7:
                data[...] = np.zeros(shape)
            elif stored.get("compression") == "gzip" and chance.random() < 0.5:
                claimed = chance.choice((8 * chunk, 10, 16 * chunk if chunk < 10**6 else 1000))
                data.id.write_direct_chunk((0,) * len(shape), zlib.compress(b"\0" * claimed))
            data.attrs["MATLAB_class"] = np.bytes_("double")
            unpacked += 8 * math.prod(shape)
    if log_format == "mat":
        with path.open("r+b") as raw:
            raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    return log_format, {}, unpacked


def make_mat73(chance: random.Random, path: Path) -> Made:
    """Write the same in the manner of MATLAB."""
    return make_hdf5(chance, path, "mat")


def make_mat(chance: random.Random, path: Path) -> Made:
    """Write packed variables of zeros: columns, a matrix, a struct."""
    from scipy.io import savemat

    rows = _rows(chance)
    columns = {name: np.zeros((rows, 1)) for name in ("t", "Fx")}
    held, options = chance.choice(
        (
            (columns, {}),
            ({"s": columns}, {"variable": "s"}),
            ({"m": np.zeros((rows, 2))}, {"variable": "m", "columns": ["t", "Fx"]}),
        )
    )
    savemat(path, held, do_compression=True, oned_as="column")
    return "mat", dict(options), 2 * 8 * rows


def make_parquet(chance: random.Random, path: Path) -> Made:
    """Write columns of one value, which take a few bytes however many rows there are."""
    from pyarrow import parquet

    rows = _rows(chance)
    kinds: tuple[Any, ...] = (
        pa.array(np.zeros(rows)),
        pa.array(np.zeros(rows, dtype=np.int8)),
        pa.nulls(rows, pa.float64()),
        pa.array(["0"] * rows).dictionary_encode(),
    )
    table = pa.table({name: chance.choice((kinds[0], *kinds)) for name in ("t", "Fx")})
    dictionary = chance.random() < 0.5
    packing = chance.choice(("zstd", "gzip", "snappy", "brotli", "none"))
    parquet.write_table(table, path, compression=packing, use_dictionary=dictionary, row_group_size=rows)
    return "parquet", {}, 2 * 8 * rows


def make_bag(chance: random.Random, path: Path) -> Made:
    """Write a bag whose chunks or messages hold one letter many thousand times."""
    letters, messages = chance.choice(((100, 3), (20_000, 4), (100_000, 3), (1000, 200)))
    unpacked = letters * messages
    for name, content in packed_bag(path.suffix, letters, messages, chance.random() < 0.5).items():
        part = path.with_suffix("") / name if path.suffix == ".db3" else path
        part.parent.mkdir(exist_ok=True)
        if content and chance.random() < 0.1:
            content, unpacked = spoilt_bytes(chance, content), 0
        part.write_bytes(content)
    return BAGS[path.suffix], {"topic": "/ft"}, unpacked


@cache
def packed_bag(ending: str, letters: int, messages: int, whole: bool) -> dict[str, bytes]:
    """Return the files of a bag packed in chunks (MCAP, ROS 1), as a whole, or message by message."""
    import tempfile

    from rosbags.rosbag1 import Writer as Ros1Writer
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    from tests.laboratory.bags import ROS1, STORE, T, as_ros1, header, vector

    def message_of(moment: int) -> Any:
        inside = T["geometry_msgs/msg/Wrench"](force=vector((0, 0, 0)), torque=vector((0, 0, 0)))
        return T["geometry_msgs/msg/WrenchStamped"](header=header(moment, "a" * letters), wrench=inside)

    moments = [1_795_248_930_000_000_000 + number * 2_000_000 for number in range(messages)]
    kind = "geometry_msgs/msg/WrenchStamped"
    plugin = StoragePlugin.MCAP if ending == ".mcap" else StoragePlugin.SQLITE3
    mode = CompressionMode.STORAGE if ending == ".mcap" else CompressionMode.FILE if whole else CompressionMode.MESSAGE
    with tempfile.TemporaryDirectory() as place:
        if ending == ".bag":
            old = Ros1Writer(Path(place) / "bag.bag")
            old.set_compression(Ros1Writer.CompressionFormat.BZ2 if whole else Ros1Writer.CompressionFormat.LZ4)
            with old:
                topic = old.add_connection("/ft", kind, typestore=ROS1)
                for moment in moments:
                    old.write(topic, moment, ROS1.serialize_ros1(as_ros1(message_of(moment)), kind))
            return {"bag.bag": (Path(place) / "bag.bag").read_bytes()}
        writer = Writer(Path(place) / "bag", version=9, storage_plugin=plugin)
        writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer:
            connection = writer.add_connection("/ft", kind, typestore=STORE)
            for moment in moments:
                writer.write(connection, moment, STORE.serialize_cdr(message_of(moment), kind))
        files = {part.name: part.read_bytes() for part in (Path(place) / "bag").iterdir()}
    return {name: held for name, held in files.items() if ending != ".mcap" or name.endswith(".mcap")}


MAKERS: tuple[tuple[str, Callable[[random.Random, Path], Made]], ...] = (
    (".csv", make_text),
    (".csv", make_text),
    (".csv", make_text),
    (".h5", make_hdf5),
    (".mat", make_mat73),
    (".mat", make_mat),
    (".parquet", make_parquet),
    (".mcap", make_bag),
    (".db3", make_bag),
    (".bag", make_bag),
)
"""Ending to what writes it; packed text is what most logs are, and the most often drawn."""
