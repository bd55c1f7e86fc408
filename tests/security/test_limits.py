"""What a file may ask for has a limit, named in the message and raised by the environment."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from stiffcal import limits
from stiffcal.campaign.model.model_editing import add_effect, editable_text, remove_effect
from stiffcal.campaign.robot.urdf.chain import read_urdf
from stiffcal.campaign.toml.toml_reading import parse_for_editing, parse_toml, read_toml
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.table_sniffing import sniff_table
from stiffcal.readers import WantedColumns, find_reader
from tests.fuzz.archives import packed_bag

DOTS = ".".join("a" * 2000)


class TestTheTableOfLimits:
    def test_every_limit_stands_in_it_with_its_default(self) -> None:
        rows = dict(re.findall(r"^``(STIFFCAL_MAX_\w+)``\s+(.*?)\s{2,}", limits.__doc__ or "", re.MULTILINE))
        assert rows == {limit.variable: limits.shown_amount(limit.default, limit.in_bytes) for limit in limits.ALL}

    @pytest.mark.parametrize("limit", limits.ALL, ids=lambda limit: limit.variable)
    def test_the_environment_raises_it_and_the_message_says_how(
        self, limit: limits.Limit, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        with pytest.raises(InputError, match=limit.variable):
            limit.check(limit.default + 1, "ft.csv")
        monkeypatch.setenv(limit.variable, str(limit.default + 1))
        limit.check(limit.default + 1, "ft.csv")

    @pytest.mark.parametrize(
        ("text", "amount"), [("3 GiB", 3 << 30), ("1.5KiB", 1536), ("2 tb", 2 * 10**12), ("7", 7), (" ", limits.TIB)]
    )
    def test_amounts_with_a_unit(self, text: str, amount: int, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", text)
        assert limits.UNPACKED.most == amount

    @pytest.mark.parametrize("text", ["much", "-1", "1e9", "5 GiB ROWS", "٣", "9" * 30, "inf"])
    def test_what_is_no_amount_is_one_line(self, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", text)
        with pytest.raises(InputError, match='STIFFCAL_MAX_UNPACKED: .* is not an amount; .*="4 TiB"'):
            limits.UNPACKED.check(1, "ft.csv.gz")


class TestPackedLogs:
    """A text log that unpacks to far more than it holds ends early, in bounded memory."""

    HEADER = b"t,Fx\n"

    def pack(self, path: Path, content: bytes) -> None:
        if path.suffix == ".zst":
            path.write_bytes(pa.compress(content, "zstd", asbytes=True))
        else:
            module = {".gz": gzip, ".bz2": bz2, ".xz": lzma}[path.suffix]
            path.write_bytes(module.compress(content))

    @pytest.mark.parametrize("ending", ["gz", "bz2", "xz", "zst"])
    @pytest.mark.parametrize("line", [b"0,0\n", b"\n", b"\0"], ids=["rows", "empty lines", "no line ends"])
    def test_bombs(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, line: bytes) -> None:
        monkeypatch.setattr(limits, "RATIO_FROM", 1 << 20)
        monkeypatch.setenv("STIFFCAL_MAX_RATIO", "50")
        monkeypatch.setenv("STIFFCAL_MAX_LINE", "1 MiB")
        self.pack(tmp_path / f"ft.csv.{ending}", self.HEADER + line * (4_000_000 // len(line)))
        reasons = "more than 50 unpacked bytes for each packed one|more than 1 MiB in one line"
        with pytest.raises(InputError, match=reasons):
            rows(tmp_path / f"ft.csv.{ending}")

    @pytest.mark.parametrize("ending", ["gz", "bz2", "xz", "zst"])
    def test_a_day_of_logs_passes(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str) -> None:
        monkeypatch.setattr(limits, "RATIO_FROM", 1 << 20)
        text = "".join(f"{k * 0.001:.3f},{(k * 7919) % 1000 / 10}\n" for k in range(100_000))
        self.pack(tmp_path / f"ft.csv.{ending}", self.HEADER + text.encode())
        assert rows(tmp_path / f"ft.csv.{ending}") == 100_000

    def test_unpacked_bytes(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", "1 MiB")
        self.pack(tmp_path / "ft.csv.gz", self.HEADER + b"1,2\n" * 300_000)
        with pytest.raises(InputError, match="more than 1 MiB once unpacked; check the file, or raise STIFFCAL_MAX_UN"):
            rows(tmp_path / "ft.csv.gz")

    @pytest.mark.parametrize("content", [b"", b"\n", b"1;2;3\n"], ids=["empty", "of one byte", "of one line"])
    def test_many_small_members_take_no_time(self, tmp_path: Path, content: bytes) -> None:
        member = gzip.compress(content)
        path = tmp_path / "ft.csv.gz"
        path.write_bytes(gzip.compress(b"t;Fx;Fy\n" + b"0.5;1.5;2.5\n" * 9) + member * (10_000_000 // len(member)))
        for look in (rows, sniff_table):
            begun = time.process_time()
            look(path)
            assert time.process_time() - begun < 0.6  # some 0.05; Python's gzip 1.6


class TestLogsInParts:
    """Parts of a log, each of which stays below the limit, are counted together."""

    @pytest.mark.parametrize(("count", "refused"), [(1, False), (2, True)])
    def test_columns(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int, refused: bool) -> None:
        from scipy.io import savemat

        monkeypatch.setattr(limits, "RATIO_FROM", 1 << 20)
        columns = {name: np.zeros((100_000, 1)) for name in ("Fx", "Fy")[:count]}
        savemat(tmp_path / "ft.mat", columns, do_compression=True)
        batches = find_reader(tmp_path / "ft.mat").read_batches(tmp_path / "ft.mat", {}, WantedColumns(tuple(columns)))
        with pytest.raises(InputError, match="STIFFCAL_MAX_RATIO") if refused else nullcontext():
            assert sum(map(len, batches)) == 100_000

    def test_rows(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_ROWS", "99999")
        pq.write_table(pa.table({"Fx": np.zeros(100_000)}), tmp_path / "ft.parquet")
        with pytest.raises(InputError, match="STIFFCAL_MAX_ROWS"):
            rows(tmp_path / "ft.parquet", "parquet")

    @pytest.mark.parametrize(
        ("ending", "whole"),
        [(".mcap", False), (".bag", False), ("", True), ("", False)],
        ids=["chunks", "chunks of ROS 1", "a file", "messages"],
    )
    @pytest.mark.parametrize(("count", "refused"), [(3, False), (4, True)])
    def test_messages(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, whole: bool, count: int, refused: bool
    ) -> None:
        """None of them is large, and a column of forces is all that is sent on."""
        # besides 20 000 letters a message has 80 bytes; the tables of a whole file take seven pages of 4 KiB
        monkeypatch.setattr(limits, "RATIO_FROM", 3 * 20_500 + 7 * 4096 * whole)
        monkeypatch.setenv("STIFFCAL_MAX_RATIO", "1")
        path = tmp_path / f"bag{ending}"
        for name, content in packed_bag(ending, 20_000, count, whole).items():
            part = path if ending else path / name
            part.parent.mkdir(exist_ok=True)
            part.write_bytes(content)
        batches = find_reader(path).read_batches(path, {"topic": "/ft"}, WantedColumns(("wrench.force.x",)))
        with pytest.raises(InputError, match="STIFFCAL_MAX_RATIO") if refused else nullcontext():
            assert sum(map(len, batches)) == count


class TestTextLogs:
    @pytest.mark.parametrize(
        "text", [b"x" * (40 << 20), b"t,Fx\n" + b"1" * (40 << 20), b't,Fx\n1,"' + b"2\n" * 2_000_000]
    )
    def test_lines_without_end_are_refused_in_bounded_time(self, tmp_path: Path, text: bytes) -> None:
        (tmp_path / "ft.csv").write_bytes(text)
        begun = time.process_time()
        with pytest.raises(InputError):
            rows(tmp_path / "ft.csv")
        assert time.process_time() - begun < 5.0

    def test_columns(self, tmp_path: Path) -> None:
        (tmp_path / "ft.csv").write_text("t,Fx" + ",x" * 25_000 + "\n" + "1," * 25_001 + "1\n")
        with pytest.raises(InputError, match="more than 20000 columns; check the file, or raise STIFFCAL_MAX_COLUMNS"):
            rows(tmp_path / "ft.csv")

    def test_rows(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_ROWS", "1000")
        (tmp_path / "ft.csv").write_text("t,Fx\n" + "1,2\n" * 1001)
        with pytest.raises(InputError, match="more than 1000 rows; check the file, or raise STIFFCAL_MAX_ROWS"):
            rows(tmp_path / "ft.csv")


class TestUrdf:
    @pytest.mark.parametrize(
        ("text", "reason"),
        [
            (
                '<!DOCTYPE robot [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>',
                "must not have a document type",
            ),
            (
                '<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot>&a;</robot>',
                "must not have a document type",
            ),
            ("<robot>" + "<a>" * 100_000, "nested elements"),
            ("<robot>" + "<link name='a'/>" * 200_001 + "</robot>", "more than 200000 elements"),
            ('<?xml version="1.0" encoding="no-such"?><robot/>', "not valid XML"),
        ],
        ids=["entities", "another file", "depth", "nodes", "encoding"],
    )
    def test_hostile_ones_are_one_line(self, tmp_path: Path, text: str, reason: str) -> None:
        (tmp_path / "robot.urdf").write_text(text)
        with pytest.raises(InputError, match=reason):
            read_urdf(tmp_path / "robot.urdf", "robot.urdf")


class TestToml:
    def test_its_bytes(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_TOML", "1 KiB")
        (tmp_path / "robot.toml").write_text("# " + "x" * 2000)
        with pytest.raises(InputError, match="robot.toml: more than 1 KiB of TOML; .* STIFFCAL_MAX_TOML"):
            read_toml(tmp_path / "robot.toml", "robot.toml")

    @pytest.mark.parametrize(
        "text",
        [
            "a = " + "[" * 20_000,
            f"{DOTS} = 1",
            f"[{DOTS}]",
            f"[[{DOTS}]]",
            f'"=".{DOTS} = 1',
            f"[{DOTS}] # ,",
            f"  [{DOTS}]",
            f"x = [1, {{ {DOTS} = 1 }}]",
            f"x = {{ y = 1, {DOTS} = 1 }}",
            f'x = """ \\""" """""\n{DOTS} = 1',
            f"x = ''' '''''\n{DOTS} = 1",
            f"x = '\\'\n{DOTS} = 1 # '",
            f'x = 1 # """\n{DOTS} = 1',
            "a" + " . 'a'" * 25 + " = 1",
            "a" + '\t.\t"a."' * 25 + " = 1",
        ],
    )
    def test_its_depth(self, tmp_path: Path, text: str) -> None:
        (tmp_path / "robot.toml").write_text(text)
        with pytest.raises(InputError) as refused:
            read_toml(tmp_path / "robot.toml", "robot.toml")
        assert refused.value.code is FaultCode.SIZE_EXCEEDED

    def test_dots_in_words_remarks_and_numbers_are_none_of_keys(self) -> None:
        words = ".".join("w" * 30)
        text = f'"{words}" = "{words}" # {words}\nwhy = """\n{words} = {words}\n"""\nc = [{", ".join(["1.5"] * 60)}]\n'
        assert parse_toml(text, "x.toml") == {words: words, "why": f"{words} = {words}\n", "c": [1.5] * 60}

    @pytest.mark.parametrize(
        "text",
        [
            "".join(f'parameters."backlash.j3.c{n}".value = 1.0\n' for n in range(1100)),
            "parameters = {" + ", ".join(f'"backlash.j3.c{n}".value = 1.0' for n in range(1100)) + "}",
            "\n" * 1100,
            " \n\t\r\n" * 600,
        ],
    )
    def test_what_the_parser_that_keeps_comments_needs_minutes_for(self, tmp_path: Path, text: str) -> None:
        model = 'schema = "stiffcal/model/1"\n[[effects]]\ntype = "backlash"\njoints = [3]\n' + text
        (tmp_path / "model.toml").write_bytes(model.encode())
        for edit in (add_effect, remove_effect):
            with pytest.raises(InputError) as refused:
                edit(editable_text(tmp_path, 6), "backlash", joints=(2,), n_joints=6)
            assert refused.value.code is FaultCode.SIZE_EXCEEDED
        assert (tmp_path / "model.toml").read_bytes() == model.encode()

    def test_the_parser_that_keeps_comments_gets_a_line_behind_spaces_in_linear_time(self) -> None:
        begun = time.process_time()
        parse_for_editing("a = 1\n" + " " * 100_000 + "b = 1\n", "x.toml", dict)
        assert time.process_time() - begun < 1.0  # some 0.05; 5 where each space is a start of its own

    def test_all_of_it_is_parsed_in_one_place(self) -> None:
        package = Path(limits.__file__).parent
        parsing = re.compile(
            r"\b(?:tomllib|tomlkit)\.(?:loads?|parse)\(|from (?:tomllib|tomlkit) import [^\n]*(?:load|parse)"
        )
        found = [
            path.relative_to(package).as_posix()
            for path in package.rglob("*.py")
            if parsing.search(path.read_text("utf-8"))
        ]
        assert found == ["campaign/toml/toml_reading.py"]


def rows(path: Path, log_format: str = "csv", column: str = "Fx") -> int:
    """Return the number of rows of a log with a column."""
    wanted = WantedColumns(numbers=(column,))
    return sum(len(batch) for batch in find_reader(path, log_format).read_batches(path, {}, wanted, path.name))
