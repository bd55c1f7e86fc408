"""Valid inputs to be spoilt, of every log format and of the TOML files."""

from __future__ import annotations

import io
import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

Maker = Callable[[random.Random, Path], None]
"""Writes one log, plain or odd in its structure."""

COLUMNS = ("t", "Fx", "Fy", "run")
ROWS = 60


def table_text(rows: int = ROWS) -> str:
    """Return a log of text with times, numbers and words."""
    lines = ["t,Fx,Fy,run"]
    lines += [f"{0.01 * k:.3f},{np.sin(k):.6g},{100.0 - k},pose{k // 20}" for k in range(rows)]
    return "\n".join(lines) + "\n"


# How HDF5 keeps a column: whole, in pieces, packed by each of its filters.
STORED: tuple[dict[str, Any], ...] = (
    {},
    {"chunks": (7,)},
    {"chunks": (30,), "maxshape": (None,)},
    {"chunks": (30,), "compression": "gzip", "shuffle": True},
    {"chunks": (30,), "compression": "lzf", "fletcher32": True},
    {"chunks": (30,), "scaleoffset": 4},
)


def _odd_column(chance: random.Random, rows: int) -> Any:
    """Return values of a kind that a column may have in a file, sensible or not."""
    kinds: tuple[Callable[[], Any], ...] = (
        lambda: np.linspace(0.0, 1.0, rows),
        lambda: np.linspace(0.0, 1.0, rows),
        lambda: np.full(rows, np.nan),
        lambda: np.full(rows, chance.choice((np.inf, 1e308, -0.0))),
        lambda: np.arange(rows, dtype=chance.choice(("i1", "u8", "f4", "i4"))),
        lambda: np.zeros((rows, chance.choice((1, 2)))),
        lambda: np.zeros((rows, 2, 2)),
        lambda: np.zeros(chance.choice((0, 1, rows - 1, rows + 1))),
        lambda: np.zeros(rows, dtype=bool),
        lambda: np.zeros(rows) + 1j,
        lambda: np.array(["2026-11-21T08:00:00"] * rows, dtype="S"),
        lambda: np.array([f"w{k}" for k in range(rows)], dtype="S"),
    )
    return chance.choice(kinds)()


def make_csv(chance: random.Random, path: Path) -> None:
    """Write a text log."""
    text = table_text(chance.choice((1, 5, ROWS)))
    if chance.random() < 0.1:  # a scope's export, with its rows of properties
        text = "Name,Fx,Fy,run\nUnit,N,N,(None)\nSampleTime[ms],1,1,1\n\n" + text.split("\n", 1)[1]
    path.write_text(text, encoding="utf-8")


def make_hdf5(chance: random.Random, path: Path) -> None:
    """Write columns, a matrix or records; sometimes links, references, sizes that no disk holds."""
    import h5py

    with h5py.File(path, "w", libver=chance.choice((None, None, "latest"))) as file:
        group = file.create_group("log") if chance.random() < 0.3 else file
        kind = chance.randrange(12)
        if kind == 0:
            data = group.create_dataset("m", data=np.zeros((ROWS, 4)), chunks=chance.choice((None, (7, 4))))
            data.attrs["columns"] = chance.choice((list(COLUMNS), "t,Fx,Fy,run", list(COLUMNS[:2]), 5, b"\xff,a,b,c"))
        elif kind == 1:
            group.create_dataset("r", data=np.zeros(ROWS, dtype=[(name, "f8") for name in COLUMNS]))
        else:
            odd = kind < 6
            stored = {} if odd else chance.choice(STORED)
            for name in COLUMNS:
                values = _odd_column(chance, ROWS) if odd and chance.random() < 0.3 else np.linspace(0.0, 1.0, ROWS)
                if name == "run" and not odd:
                    data = group.create_dataset(name, data=[f"pose{k // 20}" for k in range(ROWS)], chunks=(7,))
                else:
                    data = group.create_dataset(name, data=values, **(stored if values.ndim == 1 else {}))
                data.attrs[chance.choice(("unit", "units", "note", "scale") if odd else ("unit", "units"))] = (
                    chance.choice(("s", 3.0, b"\xff\xfe", [1, 2]) if odd else ("s", "N", b"mm"))
                )
        if kind == 2:
            group["loop"] = h5py.SoftLink("/")
            group["nowhere"] = h5py.SoftLink("/nowhere")
        elif kind == 3:
            del group["Fx"]
            group["Fx"] = h5py.ExternalLink(chance.choice(("/etc/passwd", "other.h5", str(path))), "/Fx")
        elif kind == 4:
            del group["Fx"]
            group.create_dataset("Fx", shape=(chance.choice((ROWS, 10**6, 10**15)),), dtype="f8", chunks=(50,))
        elif kind == 5:
            del group["Fx"]
            group.create_dataset("Fx", data=[group.ref] * ROWS, dtype=h5py.ref_dtype)
        elif kind == 6:
            file.create_group("x" * 300).create_group("/".join("d" * 50))


def make_parquet(chance: random.Random, path: Path) -> None:
    """Write columns of odd types, groups, lists, repeated names."""
    import pyarrow as pa
    import pyarrow.parquet as parquet

    numbers = np.linspace(0.0, 1.0, ROWS)
    arrays: list[pa.Array] = []
    for _ in COLUMNS:
        kinds: tuple[Callable[[], pa.Array], ...] = (
            lambda: pa.array(numbers),
            lambda: pa.array(numbers),
            lambda: pa.array([None, *numbers[1:]]),
            lambda: pa.array([[1.0, 2.0]] * ROWS),
            lambda: pa.array([{"x": 1.0}] * ROWS),
            lambda: pa.array(["w"] * ROWS).dictionary_encode(),
            lambda: pa.array(range(ROWS), pa.decimal128(30, 5)),
            lambda: pa.array(range(ROWS), pa.timestamp(chance.choice(("s", "ns")), "UTC")),
            lambda: pa.array(range(ROWS), pa.date32()),
            lambda: pa.array([b"\xff"] * ROWS),
            lambda: pa.nulls(ROWS),
            lambda: pa.array([True] * ROWS),
            lambda: pa.array([2**64 - 1] * ROWS, pa.uint64()),
        )
        arrays.append(chance.choice(kinds)() if chance.random() < 0.4 else pa.array(numbers))
    names = list(COLUMNS)
    if chance.random() < 0.1:
        names[chance.randrange(4)] = chance.choice(("Fx", "a.b", "", "ä"))
    table = pa.table(arrays, names=names).slice(0, chance.choice((0, 1, ROWS, ROWS)))
    parquet.write_table(table, path, row_group_size=20, compression=chance.choice(("snappy", "none", "zstd")))


def _odd_columns(chance: random.Random) -> dict[str, Any]:
    odd = chance.choice((0.0, 0.0, 0.3))
    return {name: _odd_column(chance, ROWS) if chance.random() < odd else np.linspace(0, 1, ROWS) for name in COLUMNS}


def make_mat(chance: random.Random, path: Path) -> None:
    """Write vectors, a matrix or a struct, of version 5."""
    from scipy.io import savemat

    columns = _odd_columns(chance)
    held = chance.choice((columns, {"s": columns}, {"m": np.zeros((ROWS, 4))}, columns | {"s": {"a": {"b": 1.0}}}))
    savemat(path, held, do_compression=chance.random() < 0.5, oned_as="column")


def make_mat73(chance: random.Random, path: Path) -> None:
    """Write vectors, a struct, words in cells, in the manner of version 7.3."""
    import h5py

    columns = _odd_columns(chance)
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("log") if chance.random() < 0.5 else file
        if group is not file:
            group.attrs["MATLAB_class"] = chance.choice((np.bytes_("struct"), np.bytes_("struct"), "struct", 3.0))
        if chance.random() < 0.3:
            columns.pop("run")
            held = [file.create_dataset(f"#refs#/w{k}", data=np.array([[112], [49 + k]], "u2")) for k in range(3)]
            for item in held:
                item.attrs["MATLAB_class"] = np.bytes_("char")
            words = np.array([[held[k % 3].ref for k in range(ROWS)]], dtype=h5py.ref_dtype)
            group.create_dataset("run", data=words).attrs["MATLAB_class"] = np.bytes_("cell")
        for name, values in columns.items():
            stored = (
                {"compression": "gzip", "chunks": (1, 20)} if values.shape == (ROWS,) and chance.random() < 0.3 else {}
            )
            data = group.create_dataset(name, data=np.atleast_2d(values), **stored)
            kind = chance.choice(("double",) * 12 + ("table", "cell", "struct"))
            data.attrs["MATLAB_class"] = np.bytes_(kind) if chance.random() < 0.9 else kind
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")


def make_tdms(chance: random.Random, path: Path) -> None:
    """Write channels in segments."""
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as writer:
        for part in np.array_split(np.arange(ROWS), chance.choice((1, 3))):
            channels = [ChannelObject("ft", name, np.sin(part / 5.0)) for name in COLUMNS[: chance.choice((3, 4))]]
            if chance.random() < 0.3:
                odd = chance.choice((["w"] * part.size, part.astype("datetime64[s]"), part + 1j, part.astype("i1")))
                channels.append(
                    ChannelObject("ft", "odd", odd, {"wf_increment": chance.choice((0.01, -1.0, float("nan")))})
                )
            writer.write_segment(channels)


@cache
def bag_bytes(ending: str) -> bytes:
    """Return a bag of two topics, wrenches and transforms."""
    import tempfile

    from tests.laboratory.bags import transforms, wrench, write_bag

    moments = [1_795_248_930_000_000_000 + k * 2_000_000 for k in range(ROWS)]
    topics = {
        "/ft": [(moment, wrench(moment, np.sin(np.arange(6) + k))) for k, moment in enumerate(moments)],
        "/tf": [(moment, transforms(moment, {"a": (1.0, 2.0, 3.0)})) for moment in moments],
    }
    with tempfile.TemporaryDirectory() as place:
        return write_bag(Path(place) / f"log{ending}", topics).read_bytes()


def make_bag(chance: random.Random, path: Path) -> None:
    """Write a bag."""
    path.write_bytes(bag_bytes(path.suffix))


def packed(chance: random.Random, data: bytes) -> tuple[str, bytes]:
    """Pack a text log; return the ending that goes with it."""
    import bz2
    import gzip
    import lzma

    ending, pack = chance.choice(((".gz", gzip.compress), (".bz2", bz2.compress), (".xz", lzma.compress)))
    return ending, pack(data)


def bomb() -> bytes:
    """Return a packed log that grows a thousandfold: one line of 200 MB."""
    import gzip

    text = io.BytesIO()
    with gzip.GzipFile(fileobj=text, mode="wb", compresslevel=1) as file:
        file.write(b"t,Fx\n")
        for _ in range(200):
            file.write(b"1" * 1_000_000)
    return text.getvalue()


MAKERS: dict[str, tuple[str, str, Maker]] = {
    "csv": ("csv", ".csv", make_csv),
    "hdf5": ("hdf5", ".h5", make_hdf5),
    "mat": ("mat", ".mat", make_mat),
    "mat 7.3": ("mat", ".mat", make_mat73),
    "mcap": ("mcap", ".mcap", make_bag),
    "rosbag1": ("rosbag1", ".bag", make_bag),
    "rosbag2": ("rosbag2", ".db3", make_bag),
    "parquet": ("parquet", ".parquet", make_parquet),
    "tdms": ("tdms", ".tdms", make_tdms),
}
"""Target to format, ending and maker."""
