"""Logs from a stranger: nothing in them runs, leads outside, never ends or takes the machine's memory."""

from __future__ import annotations

import os
import pickle
import shutil
import sqlite3
import struct
import sys
import time
import zlib
from contextlib import closing, suppress
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import damaged_file_errors
from stiffcal.parsers import hdf5_files
from stiffcal.readers import Options, WantedColumns, find_reader
from tests.laboratory.bags import STORE, wrench, write_bag
from tests.laboratory.log_reading import parse_here

WAYS_OUT = (
    "link", "linked group", "soft link", "raw storage", "virtual", "virtual of a link", "raw storage in mat",
    "link in mat", "virtual in mat", "below", "without a name",
)  # fmt: skip
REFUSED = (FaultCode.FILE_DAMAGED, FaultCode.SIZE_EXCEEDED)
LONG_S = 60.0  # on a machine that has other things to do; what never ends would take longer
FORCE = WantedColumns(numbers=("wrench.force.x",))


def read(path: Path, wanted: WantedColumns = FORCE, options: Options | None = None) -> int:
    """Return the number of rows of a log."""
    reader = find_reader(path, display_name=path.name)
    options = options or {}
    reader.tables(path, path.name)
    reader.read_header(path, options, path.name, wanted)
    return sum(len(batch) for batch in reader.read_batches(path, options, wanted, path.name))


def fault_of(path: Path, wanted: WantedColumns = FORCE, options: Options | None = None) -> Fault:
    """Return the fault for which a log is refused."""
    begun = time.monotonic()
    with pytest.raises(InputError) as refused:
        read(path, wanted, options)
    assert time.monotonic() - begun < LONG_S
    (fault,) = refused.value.faults
    assert fault.mend
    assert "\n" not in str(fault)
    return fault


def refusal(path: Path, wanted: WantedColumns = FORCE, options: Options | None = None) -> str:
    """Return the one line with which a log is refused."""
    return str(fault_of(path, wanted, options))


@pytest.fixture(autouse=True)
def short_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a parser that never ends be ended after a second."""
    monkeypatch.setenv("STIFFCAL_MAX_SECONDS", "1")


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    messages = [(10**18 + k, wrench(10**18 + k, np.arange(6.0) + k)) for k in range(20)]
    return write_bag(tmp_path_factory.mktemp("bag") / "ft.db3", {"/ft": messages})


def with_chunk(content: bytes, packing: str, packed: bytes, stated: int) -> bytes:
    """Return an MCAP file whose index lists one chunk, which is put in here, in place of all others."""
    (summary,) = struct.unpack("<Q", content[-28:-20])
    name = struct.pack("<I", len(packing)) + packing.encode()
    chunk = struct.pack("<QQQI", 0, 19, stated, 0) + name + struct.pack("<Q", len(packed)) + packed
    place, records, channels = summary, b"", b""
    while content[place] not in (0x0E, 0x02):
        (size,) = struct.unpack("<Q", content[place + 1 : place + 9])
        record = content[place : place + 9 + size]
        if content[place] == 0x08:
            (length,) = struct.unpack("<I", record[41:45])
            channels = record[41 : 45 + length]
        else:
            records += record
        place += 9 + size
    index = struct.pack("<QQQQ", 0, 19, summary, 9 + len(chunk)) + channels + struct.pack("<Q", 0) + name
    index += struct.pack("<QQ", len(packed), stated)
    records += b"\x08" + struct.pack("<Q", len(index)) + index
    chunk = b"\x06" + struct.pack("<Q", len(chunk)) + chunk
    footer = content[-37:-28] + struct.pack("<Q", summary + len(chunk)) + content[-20:]
    return content[:summary] + chunk + records + footer


class TestBags:
    """Definitions of messages are made into Python by rosbags; the rest of a bag is SQLite, YAML and packed chunks."""

    @pytest.fixture
    def bag(self, sound: Path, tmp_path: Path) -> Path:
        shutil.copy(sound, tmp_path / "ft.db3")
        return tmp_path / "ft.db3"

    def change(self, bag: Path, *commands: str, values: tuple[object, ...] = ()) -> None:
        with closing(sqlite3.connect(bag)) as database:
            for command in commands:
                database.execute(command, values)
            database.commit()

    def define(self, bag: Path, definition: str, encoding: str = "ros2msg") -> None:
        values = (definition, encoding)
        self.change(bag, "UPDATE message_definitions SET encoded_message_definition = ?, encoding = ?", values=values)
        self.change(bag, "UPDATE topics SET type_description_hash = ''")
        self.change(bag, "UPDATE message_definitions SET type_description_hash = ''")

    def test_a_sound_bag_is_read(self, bag: Path) -> None:
        assert read(bag) == 20

    @pytest.mark.parametrize(
        ("definition", "reason"),
        [
            ("Other other\n", "no definition of this type"),
            ("float64[-1] x\n", "an array of -1 elements"),
            ("float64[0] x\n", "an array of 0 elements"),
            ("float64 x\nfloat64 x\n", "a field has the name 'x'"),
            ("float64 x__\n", "a field has the name 'x__'"),
        ],
    )
    def test_hostile_definitions(self, bag: Path, definition: str, reason: str) -> None:
        self.define(bag, definition)
        line = refusal(bag)
        assert reason in line
        assert "message type geometry_msgs/msg/" in line

    @pytest.mark.parametrize(
        "definition",
        [
            "geometry_msgs/WrenchStamped inside\n",
            "float64[2000000000] x\n",
            "string[1000000] x\n",
            "".join(f"float64 x{number}\n" for number in range(3000)),
        ],
        ids=["itself", "a long array", "an array that is written out", "many fields"],
    )
    def test_definitions_that_ask_for_much(self, bag: Path, definition: str) -> None:
        self.define(bag, definition)
        assert fault_of(bag).code in REFUSED

    @pytest.mark.parametrize(
        "constant", ["(" * 30 + "1" + ")" * 30, "(1))", "1 << 100000000000", "9 * 9"], ids=range(4)
    )
    def test_definitions_in_idl_that_are_computed_for_ever(self, bag: Path, constant: str) -> None:
        struct_text = f"const long N = {constant}; struct WrenchStamped {{ double x; }};"
        self.define(bag, f"module geometry_msgs {{ module msg {{ {struct_text} }}; }};", "ros2idl")
        assert fault_of(bag).code in REFUSED

    def test_constants_and_defaults_reach_no_generated_code(self, bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        from rosbags.typesys import store

        seen: list[object] = []
        generate = vars(store)["generate_python_code"]

        def generated(types: object, *rest: object) -> object:
            seen.append(types)
            return generate(types, *rest)

        monkeypatch.setitem(vars(store), "generate_python_code", generated)
        parse_here(monkeypatch, 10)
        text = 'string ATTACK=\'"""\\n__import__("os").system("false")\'\nfloat64 inf 1e999\nfloat64 SIZE=1e999\n'
        self.define(bag, text)
        with pytest.raises(InputError):
            read(bag)
        (types,) = seen
        assert types == {"geometry_msgs/msg/WrenchStamped": ([], [("inf", (1, ("float64", 0)))])}

    @pytest.mark.parametrize("name", ["a", "a/b c", "a/b\nimport os", "a//b", "a/b.c", "../a/b", "a/" + "b" * 300])
    def test_names_of_types_that_are_none(self, bag: Path, name: str) -> None:
        self.change(bag, "UPDATE topics SET type = ?", values=(name,))
        self.change(bag, "UPDATE message_definitions SET topic_type = ?", values=(name,))
        refusal(bag)

    def test_a_view_that_never_ends(self, bag: Path) -> None:
        endless = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT k AS id, 1 AS topic_id"
        self.change(
            bag,
            "ALTER TABLE messages RENAME TO kept",
            f"CREATE VIEW messages AS {endless}, k AS timestamp, zeroblob(10) AS data FROM n",
        )
        assert "view that computes its rows" in refusal(bag)

    def test_columns_that_are_computed(self, bag: Path) -> None:
        self.change(
            bag,
            "ALTER TABLE messages RENAME TO kept",
            "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, data AS (zeroblob(900000000)))",
        )
        assert "computed columns" in refusal(bag)

    def test_messages_that_lie_in_a_journal_are_not_lost_in_silence(self, bag: Path) -> None:
        with closing(sqlite3.connect(bag)) as database:
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("INSERT INTO messages SELECT id + 100, topic_id, timestamp + 100, data FROM messages")
            database.commit()
            for ending in ("", "-wal"):
                shutil.copy(bag.with_name(f"ft.db3{ending}"), bag.with_name(f"copy.db3{ending}"))
        assert "part of the messages is in copy.db3-wal" in refusal(bag.with_name("copy.db3"))

    def test_nothing_is_written_into_the_folder(self, bag: Path) -> None:
        before = {path: path.stat().st_mtime_ns for path in bag.parent.iterdir()}
        read(bag)
        assert {path: path.stat().st_mtime_ns for path in bag.parent.iterdir()} == before

    @pytest.mark.parametrize("name", ["..%2fsecret%2fft.db3", "x?immutable=0&y=.db3", "100 % #1.db3", "käse.db3"])
    def test_a_file_name_leads_to_no_other_file(self, bag: Path, tmp_path: Path, name: str) -> None:
        secret = tmp_path / "secret"
        secret.mkdir()
        shutil.copy(bag, secret / "ft.db3")
        self.change(secret / "ft.db3", "DELETE FROM messages WHERE id > 3")
        raw = tmp_path / "raw"
        raw.mkdir()
        shutil.copy(secret / "ft.db3", raw / "x")
        shutil.copy(bag, raw / name)
        assert read(raw / name) == 20

    @pytest.mark.parametrize("text", ["[" * 1500, "{a: " * 5000, "- " * 5000, "a: " + "&a [*a]" + "[" * 4000])
    def test_metadata_that_nests(self, bag: Path, text: str) -> None:
        folder = bag.parent / "bag"
        folder.mkdir()
        (folder / "metadata.yaml").write_text(text)
        assert fault_of(folder).code in REFUSED
        self.change(bag, "UPDATE topics SET offered_qos_profiles = ?", values=(text,))
        assert fault_of(bag).code in REFUSED

    def test_files_of_a_folder_lie_in_it_and_are_regular(self, bag: Path) -> None:
        folder = bag.parent / "bag"
        folder.mkdir()
        (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}")
        if hasattr(os, "mkfifo"):
            os.mkfifo(folder / "bag_0.db3")
            assert refusal(folder).startswith("bag/bag_0.db3: this is a pipe")

    @pytest.mark.skipif(sys.platform == "win32", reason="the size of files cannot be bounded there")
    def test_a_packed_file_that_unpacks_to_far_more(self, bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer

        writer = Writer(bag.parent / "bag", version=9)
        writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
        with writer:
            connection = writer.add_connection("/ft", "geometry_msgs/msg/WrenchStamped", typestore=STORE)
            message = STORE.serialize_cdr(wrench(1, np.zeros(6)), "geometry_msgs/msg/WrenchStamped")
            for moment in range(9):
                writer.write(connection, moment, message)
        assert read(bag.parent / "bag") == 9
        (packed,) = bag.parent.glob("bag/*.zstd")
        packed.write_bytes(pa.compress(b"\0" * (9 << 20), "zstd", asbytes=True))
        monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", "8 MiB")
        assert "STIFFCAL_MAX_UNPACKED" in refusal(bag.parent / "bag")

    @pytest.mark.parametrize("packing", ["lz4", "zstd"])
    @pytest.mark.parametrize("stated", [256 << 20, 1 << 40])
    def test_a_chunk_that_unpacks_to_far_more(
        self, tmp_path: Path, packing: str, stated: int, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        import lz4.frame  # type: ignore[import-untyped]

        monkeypatch.setenv("STIFFCAL_MAX_PIECE", "64 MiB")
        content = b"\0" * (256 << 20)
        packed = lz4.frame.compress(content) if packing == "lz4" else pa.compress(content, "zstd", asbytes=True)
        path = write_bag(tmp_path / "ft.mcap", {"/ft": [(k, wrench(k, np.zeros(6))) for k in range(20)]})
        path.write_bytes(with_chunk(path.read_bytes(), packing, packed, stated))
        assert fault_of(path).code in REFUSED

    def test_an_index_that_lists_a_chunk_twice(self, tmp_path: Path) -> None:
        messages = [(10**18 + k, wrench(10**18 + k, np.arange(6.0) + k)) for k in range(20)]
        path = write_bag(tmp_path / "ft.mcap", {"/ft": messages})
        content = path.read_bytes()
        assert read(path) == 20
        (summary,) = struct.unpack("<Q", content[-28:-20])
        place, records = summary, b""
        while content[place] != 0x0E and content[place] != 0x02:
            (size,) = struct.unpack("<Q", content[place + 1 : place + 9])
            records += content[place : place + 9 + size] * (2 if content[place] == 0x08 else 1)
            place += 9 + size
        path.write_bytes(content[:summary] + records + content[-37:])
        assert "its index lists a chunk twice" in refusal(path)


class TestHdf5:
    """A link can lead to any file; a chunk of a few kilobytes can unpack to gigabytes."""

    FX = WantedColumns(numbers=("Fx",))

    @pytest.fixture
    def secret(self, tmp_path: Path) -> Path:
        outside = tmp_path / "outside"
        outside.mkdir()
        with h5py.File(outside / "secret.h5", "w") as file:
            file["Fx"] = np.arange(5.0)
            file["inside/Fx"] = np.arange(5.0)
        (outside / "secret.bin").write_bytes(np.arange(5.0).tobytes())
        return outside

    @pytest.mark.parametrize("way", WAYS_OUT)
    def test_nothing_outside_the_file_is_opened(self, tmp_path: Path, secret: Path, way: str) -> None:
        path = tmp_path / ("ft.mat" if way.endswith("mat") else "ft.h5")
        shape = (1, 5) if way.endswith("mat") else (5,)
        options: dict[str, object] = {}
        with h5py.File(path, "w") as file:
            if way in ("link", "link in mat"):
                file["Fx"] = h5py.ExternalLink(str(secret / "secret.h5"), "/Fx")
            elif way == "linked group":
                file["log"] = h5py.ExternalLink(str(secret / "secret.h5"), "/inside")
                options = {"group": "/log"}
            elif way == "soft link":
                file["log"] = h5py.ExternalLink(str(secret / "secret.h5"), "/inside")
                file["Fx"] = h5py.SoftLink("/log/Fx")
            elif way.startswith("virtual"):
                here = way == "virtual of a link"
                if here:
                    file["hidden"] = h5py.ExternalLink(str(secret / "secret.h5"), "/Fx")
                layout = h5py.VirtualLayout(shape, "f8")
                source = h5py.VirtualSource(
                    "." if here else str(secret / "secret.h5"), "hidden" if here else "Fx", (5,)
                )
                layout[:] = source
                file.create_virtual_dataset("Fx", layout)
            else:
                place = file.create_group("a/b/c") if way == "below" else file
                place.create_dataset("Fx", shape, "f8", external=[(str(secret / "secret.bin"), 0, 40)])
                file["Fy"] = np.arange(5.0)
        for goal in ("secret.h5", "secret.bin"):  # what would be opened would be waited for
            (secret / goal).unlink()
            if hasattr(os, "mkfifo"):
                os.mkfifo(secret / goal)
        wanted = WantedColumns(("Fy",)) if way == "below" else self.FX
        assert fault_of(path, wanted, options).code is FaultCode.FILE_OUTSIDE

    @pytest.mark.parametrize("of", ["itself", "another", "stripes"])
    def test_datasets_put_together_from_the_files_own_are_refused(self, tmp_path: Path, of: str) -> None:
        """Of itself one ends the process, in stripes it takes the square of its length."""
        with h5py.File(tmp_path / "ft.h5", "w") as file:
            file["d0"] = np.zeros(1000)
            layout = h5py.VirtualLayout((1000,), "f8")
            source = h5py.VirtualSource(".", "Fx" if of == "itself" else "d0", (1000,))
            if of == "stripes":
                layout[0::2], layout[1::2] = source[0::2], source[1::2]
            else:
                layout[:] = source
            file.create_virtual_dataset("Fx", layout)
        assert fault_of(tmp_path / "ft.h5", self.FX).code is FaultCode.FILE_OUTSIDE
        assert fault_of(tmp_path / "ft.h5", WantedColumns(("d0",))).code is FaultCode.FILE_OUTSIDE

    @pytest.mark.parametrize("named", [True, False])
    def test_a_word_in_a_cell_is_not_read_from_another_file(
        self, tmp_path: Path, secret: Path, named: bool, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """A reference reaches what has no name any more, and is not among what is looked at first."""
        with h5py.File(tmp_path / "ft.mat", "w") as file:
            word = file.create_dataset("#refs#/a", (1, 20), "u2", external=[(str(secret / "secret.bin"), 0, 40)])
            word.attrs["MATLAB_class"] = np.bytes_(b"char")
            cells = file.create_dataset("run", (1, 3), h5py.ref_dtype)
            cells[...] = np.full((1, 3), word.ref, h5py.ref_dtype)
            cells.attrs["MATLAB_class"] = np.bytes_(b"cell")
        if not named:
            parse_here(monkeypatch, 10)
            monkeypatch.setattr(hdf5_files, "_refuse_ways_out", lambda *_: None)
        wanted = WantedColumns(numbers=(), texts=("run",))
        assert fault_of(tmp_path / "ft.mat", wanted).code is FaultCode.FILE_OUTSIDE

    def test_links_in_a_circle(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "ft.h5", "w") as file:
            file["a/Fx"] = np.arange(5.0)
            file["a/again"] = file["a"]
            file["Fx"] = h5py.SoftLink("/Fy")
            file["Fy"] = h5py.SoftLink("/Fx")
            file["far"] = h5py.SoftLink("/a/again/again/again")
        assert "no column 'Fx'" in refusal(tmp_path / "ft.h5", self.FX)
        assert "no group '/Fx'" in refusal(tmp_path / "ft.h5", self.FX, {"group": "/Fx"})
        assert read(tmp_path / "ft.h5", self.FX, {"group": "/far"}) == 5

    def test_a_chunk_that_unpacks_to_gigabytes(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "ft.h5", "w") as file:
            made = file.create_dataset("Fx", (1 << 27,), "f8", chunks=(1 << 27,), compression="gzip")
            made.id.write_direct_chunk((0,), zlib.compress(b"\0" * 1000))
        assert fault_of(tmp_path / "ft.h5", self.FX).code in REFUSED

    def test_chunks_that_do_not_fit_into_memory_together(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_PIECE", "4 MiB")
        with h5py.File(tmp_path / "ft.h5", "w") as file:
            file.create_dataset("Fx", data=np.arange(1 << 20, dtype=float), chunks=(1 << 20,), compression="gzip")
        assert "more than 4 MiB of memory at once; check the file, or raise STIFFCAL_MAX_PIECE" in refusal(
            tmp_path / "ft.h5", self.FX
        )

    @pytest.mark.parametrize("layout", ["columns", "table", "records", "mat"])
    def test_a_large_chunk_is_unpacked_once(self, tmp_path: Path, layout: str, monkeypatch: pytest.MonkeyPatch) -> None:
        parse_here(monkeypatch, 5000)
        n_rows = 300_000
        values = np.random.default_rng(1).normal(size=n_rows)
        name, path = "Fx", tmp_path / ("ft.mat" if layout == "mat" else "ft.h5")
        with h5py.File(path, "w") as file:
            packing = {"chunks": (n_rows // 2,), "compression": "gzip"}
            if layout == "columns":
                file.create_dataset("Fx", data=values, **packing)
            elif layout == "records":
                file.create_dataset("log", data=values.astype([("Fx", "f8")]), **packing)
            elif layout == "table":
                made = file.create_dataset("log", data=values[:, None] * [1, 2], chunks=(n_rows // 2, 2), compression=1)
                made.attrs["columns"] = "Fx,Fy"
            else:
                file.create_dataset("Fx", data=values[None], chunks=(1, n_rows // 2), compression=1)
        begun = time.process_time()
        found = [batch.numbers[name] for batch in find_reader(path).read_batches(path, {}, self.FX)]
        assert time.process_time() - begun < 1.0
        assert np.array_equal(np.concatenate(found), values)


class TestMat:
    def test_a_variable_that_unpacks_to_gigabytes(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        from scipy.io import savemat

        monkeypatch.setenv("STIFFCAL_MAX_PIECE", "32 MiB")
        savemat(tmp_path / "ft.mat", {"Fx": np.zeros((1 << 23, 1))}, do_compression=True)
        assert "STIFFCAL_MAX_PIECE" in refusal(tmp_path / "ft.mat", WantedColumns(numbers=("Fx",)))


class TestParquet:
    def test_one_long_word_in_every_row(self, tmp_path: Path) -> None:
        words = pa.DictionaryArray.from_arrays(pa.array(np.zeros(60_000, np.int32)), pa.array(["x" * (1 << 20)]))
        pq.write_table(pa.table({"run": words, "Fx": np.arange(60_000.0)}), tmp_path / "ft.parquet")
        assert read(tmp_path / "ft.parquet", WantedColumns(numbers=("Fx",), texts=("run",))) == 60_000
        assert "not numbers" in refusal(tmp_path / "ft.parquet", WantedColumns(numbers=("run",)))

    @pytest.mark.parametrize(("letters", "piece"), [(20 << 20, ""), (80 << 20, "64 MiB")])
    def test_one_word_larger_than_any(
        self, tmp_path: Path, letters: int, piece: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """The word is longer than a line may be, or the memory that is allowed does not hold it."""
        if piece:
            monkeypatch.setenv("STIFFCAL_MAX_PIECE", piece)
        words = pa.DictionaryArray.from_arrays(pa.array(np.zeros(3, np.int32)), pa.array(["x" * letters]))
        pq.write_table(pa.table({"run": words}), tmp_path / "ft.parquet", compression="zstd")
        assert fault_of(tmp_path / "ft.parquet", WantedColumns((), ("run",))).code is FaultCode.SIZE_EXCEEDED

    def test_more_rows_than_a_file_of_its_size_can_hold(self, tmp_path: Path) -> None:
        with pq.ParquetWriter(tmp_path / "ft.parquet", pa.schema([("Fx", pa.float64())])) as writer:
            zeros = pa.table({"Fx": np.zeros(1 << 20)})
            for _ in range(65):
                writer.write_table(zeros, row_group_size=1 << 20)
        assert "STIFFCAL_MAX_RATIO" in refusal(tmp_path / "ft.parquet", WantedColumns(numbers=("Fx",)))

    def test_lists_in_cells(self, tmp_path: Path) -> None:
        pq.write_table(pa.table({"Fx": [[1.0, 2.0], [3.0]]}), tmp_path / "ft.parquet")
        assert "list<" in refusal(tmp_path / "ft.parquet", WantedColumns(numbers=("Fx.list.element",)))

    def test_a_pickled_type_of_columns_is_not_loaded(self, tmp_path: Path) -> None:
        class Attack:
            def __reduce__(self) -> tuple[object, tuple[str]]:
                return os.system, (f"touch {tmp_path / 'attacked'}",)

        attack = pickle.dumps(Attack())
        marked = {
            b"ARROW:extension:name": b"arrow.py_extension_type",
            b"ARROW:extension:metadata": attack,
        }
        schema = pa.schema([pa.field("Fx", pa.float64(), metadata=marked)])
        pq.write_table(pa.table({"Fx": np.arange(3.0)}, schema=schema), tmp_path / "ft.parquet")
        with suppress(InputError):
            read(tmp_path / "ft.parquet", WantedColumns(numbers=("Fx",)))
        assert not (tmp_path / "attacked").exists()


class TestTdms:
    def test_the_index_next_to_a_file_is_not_read(self, tmp_path: Path) -> None:
        nptdms = pytest.importorskip("nptdms")
        with nptdms.TdmsWriter(tmp_path / "ft.tdms") as writer:
            writer.write_segment([nptdms.ChannelObject("log", "Fx", np.arange(5.0))])
        (tmp_path / "ft.tdms_index").write_bytes(b"TDSh" + b"\xff" * 100)
        assert read(tmp_path / "ft.tdms", WantedColumns(numbers=("Fx",))) == 5

    @pytest.mark.parametrize("place", ["channel", "group", "root"])
    @pytest.mark.parametrize(
        "properties",
        [
            {"NI_Number_Of_Scales": 2**31 - 1},
            {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Polynomial",
             "NI_Scale[0]_Polynomial_Coefficients_Size": 2**31 - 1},
        ],
        ids=["scalings", "coefficients"],
    )  # fmt: skip
    def test_scalings_without_number(self, tmp_path: Path, place: str, properties: dict[str, object]) -> None:
        nptdms = pytest.importorskip("nptdms")
        held = {name: properties if name == place else {} for name in ("root", "group", "channel")}
        with nptdms.TdmsWriter(tmp_path / "ft.tdms") as writer:
            writer.write_segment(
                [
                    nptdms.RootObject(properties=held["root"]),
                    nptdms.GroupObject("log", properties=held["group"]),
                    nptdms.ChannelObject("log", "Fx", np.arange(5.0), properties=held["channel"]),
                ]
            )
        assert fault_of(tmp_path / "ft.tdms", WantedColumns(numbers=("Fx",))).code in REFUSED


@pytest.mark.parametrize("field", ["sqlite_errorcode", "result"], ids=["of Python", "of apsw"])
def test_a_database_that_gets_no_memory_is_not_called_damaged(field: str) -> None:
    """A row may be as large as memory: the child process then states the limit."""

    class NoMemoryError(Exception):
        pass

    error = NoMemoryError("out of memory")
    setattr(error, field, 7)
    with pytest.raises(MemoryError), damaged_file_errors("bag", "a.db3"):
        raise error
