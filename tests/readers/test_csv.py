"""CSV: what real loggers write is read to the last digit; what is broken is named by line and column."""

from __future__ import annotations

import bz2
import gzip
import lzma
import tempfile
import time
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pyarrow as pa
import pytest
from hypothesis import example, given, settings
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.readers import csv as csv_module
from stiffcal.readers.csv.lines import LogText
from tests.laboratory.log_reading import read_columns, refusal

READER = find_reader(Path("x.csv"))
COLUMNS = ("t", "Fx", "Fy")
WANTED = WantedColumns(COLUMNS)


def read(
    content: bytes, wanted: WantedColumns = WANTED, name: str = "log.csv", **options: Any
) -> dict[str, NDArray[Any]]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_columns(READER, path, options, wanted, name)


def fault(content: bytes, wanted: WantedColumns = WANTED, **options: Any) -> str:
    return refusal(lambda: read(content, wanted, **options), "log.csv").removeprefix("log.csv: ")


PLAIN = b"t,Fx,Fy\n0.0,1.5,-2.25\n0.1,+3e2,4\n"
PACKED = {
    "gz": gzip.compress(PLAIN, mtime=0),
    "bz2": bz2.compress(PLAIN),
    "xz": lzma.compress(PLAIN),
    "zst": pa.compress(PLAIN, codec="zstd", asbytes=True),
}
EXPECTED = {"t": [0.0, 0.1], "Fx": [1.5, 300.0], "Fy": [-2.25, 4.0]}


@pytest.mark.parametrize(
    ("content", "options"),
    [
        (PLAIN, {}),
        (PLAIN.replace(b"\n", b"\r\n"), {}),
        (PLAIN.replace(b"\n", b"\r"), {}),
        (PLAIN.replace(b"\n", b"\n\n"), {}),
        (PLAIN + b"\n\r\n\n", {}),
        (b"\xef\xbb\xbf" + PLAIN, {}),
        (PLAIN.replace(b",", b"\t"), {}),
        (PLAIN.replace(b",", b"|"), {"delimiter": "|"}),
        (PLAIN.replace(b",", b" ; "), {"delimiter": ";"}),
        (PLAIN.replace(b",", b" "), {}),
        (PLAIN.replace(b",", b"\t"), {"delimiter": "tab"}),
        (PLAIN.replace(b",", b";").replace(b".", b","), {"decimal": ","}),
        (b'"t","Fx","Fy"\n"0,0","1,5","-2,25"\n"0,1","3e2","4"\n', {"decimal": ","}),
        (b"Logger 3; \xb5m\nsecond, line\n\n" + PLAIN, {"skip_rows": 3}),
        (b"Logger 3; \xb5m\nsecond, line\n\n" + PLAIN, {"skip_rows": 3, "encoding": "latin-1"}),
        *((PLAIN.decode().encode("utf-16"), options) for options in ({}, {"encoding": "utf-16"})),
        (PLAIN.decode().encode("utf-16-le"), {}),
        *((PLAIN.decode().encode(f"utf-32{order}"), {}) for order in ("", "-le", "-be")),
        (("\ufeff" + PLAIN.decode()).encode("utf-32-be"), {}),
        (PLAIN.replace(b"+3e2", b"+3.0D+02").replace(b"1.5", b".15d1"), {}),
        (PLAIN.replace(b"+3e2", b"3,D2").replace(b",", b";").replace(b"3;D2", b"3,0D+02").replace(b".", b","), {}),
        (PLAIN.replace(b",", b";").replace(b".", b","), {}),
        (PLAIN.replace(b",", b"  \t "), {}),
        (b"   t    Fx    Fy  \n" + PLAIN[8:].replace(b",", b"   ").replace(b"\n", b"  \n  "), {}),
        (b"# " + PLAIN.replace(b",", b" "), {}),
        (PLAIN.replace(b",", b";").replace(b"+3e2", b'"300.0"').replace(b"4", b"4.0"), {}),
        (PLAIN.replace(b"Fy\n", b"Fy,,\n").replace(b"5\n", b"5,,\n").replace(b"4\n", b"4,,\n"), {}),
        (PLAIN.replace(b"Fy\n", b"Fy,Comment\n"), {}),
        (b"Logger\n" + PLAIN, {}),
        ("Zeitäöü;t;Fx;Fy\nä;0,0;1,5;-2,25\nö;0,1;3e2;4\n".encode("cp1252"), {}),
        (PLAIN.replace(b"Fy\n", b"Fy\ns,N,N\n"), {}),
        (PLAIN.replace(b"Fy\n", b"Fy\n[s],[kN],[N*m]\n"), {}),
        (PLAIN.replace(b"Fy\n", b"Fy\nSekunden,x,y\n"), {"unit_row": True}),
        (b'note,t,Fx,Fy\n5",0.0,1.5,-2.25\n\xff\xfe,0.1,3e2,4\n', {}),
        (PLAIN.replace(b"\n", b",\n"), {}),
        *((packed, {}) for packed in PACKED.values()),
        (PACKED["zst"] + pa.compress(b"", codec="zstd", asbytes=True), {}),
        (bz2.compress(PLAIN[:13]) + bz2.compress(PLAIN[13:]), {}),
        (pa.compress(PLAIN[:13], codec="zstd", asbytes=True) + pa.compress(PLAIN[13:], codec="zstd", asbytes=True), {}),
    ],
)
def test_what_loggers_write_is_read(content: bytes, options: dict[str, Any]) -> None:
    found = read(content, **options)
    assert {name: values.tolist() for name, values in found.items()} == EXPECTED


def test_units_and_what_was_detected_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes("t;Fx;Drehmoment\n[ms];[N];[N·m]\n1;2;3\n".encode("cp1252"))
    header = READER.read_header(path, {"encoding": "cp1252"})
    assert header.columns == ("t", "Fx", "Drehmoment")
    assert header.units == {"t": "ms", "Fx": "N", "Drehmoment": "N·m"}
    assert header.options["delimiter"] == ";"
    assert READER.place_of_row(path, {"encoding": "cp1252"}, 1) == "line 3"


def test_a_first_row_of_words_and_numbers_is_data() -> None:
    wanted = WantedColumns(("Fx",), texts=("run",))
    found = read(b"run,Fx\nm,1\nN,2\n", wanted)
    assert found["run"].tolist() == ["m", "N"]
    assert "line 2, column Fx: 'ERR'" in fault(b"run,Fx\na,ERR\nb,2\n", wanted)


def test_words_times_and_gaps() -> None:
    wanted = WantedColumns(("Fx", "m1"), texts=("run",), times=("when",), gaps=frozenset({"m1"}))
    rows = ["Posé 1;2026-11-21T08:00:00,25;1;", "b;2026-11-21 09:00:01.5+01:00;2;NaN", "b;2026-11-21T08:00:02Z;3;4"]
    content = "\n".join(["run;when;Fx;m1", *rows, ""])
    found = read(content.encode("latin-1"), wanted, encoding="latin-1")
    assert found["run"].tolist() == ["Posé 1", "b", "b"]
    assert np.allclose(np.diff(found["when"]), [1.25, 0.5], atol=1e-6)
    assert np.array_equal(found["m1"], [np.nan, np.nan, 4], equal_nan=True)
    assert "line 3, column Fx: the cell is empty" in fault(
        b"Fx,m1\n1,2\n,3\n", WantedColumns(("Fx", "m1"), gaps=frozenset({"m1"}))
    )
    assert "column when: 'noon' is no date or time" in fault(
        b"when,Fx\nnoon,3\n", WantedColumns(("Fx",), times=("when",))
    )


HEADED = b"Logger\nfirmware 3\n" + PLAIN


@pytest.mark.parametrize(
    ("content", "options", "expected"),
    [
        (b"", {}, "the file is empty; log again"),
        (b"t,Fx,Fy\n", {}, "line 2: no data after the header"),
        (b"t,Fx,Fy", {}, "line 2: no data after the header"),
        (b"a\nb\n", {"skip_rows": 5}, "the file ends before its header (csv.skip_rows is 5); correct csv.skip_rows"),
        (HEADED, {"skip_rows": 1}, "no column 't' nor 2 others; the names are in line 3: set csv.skip_rows = 2"),
        (PLAIN, {"delimiter": ";"}, 'the names are in line 1: set csv.delimiter = ","'),
        (PLAIN.replace(b"Fx", b"fx"), {}, "line 1: no column 'Fx'; did you mean 'fx'?"),
        (PLAIN.replace(b"Fx", b"Fx [N]"), {}, "line 1: no column 'Fx'; did you mean 'Fx [N]'?"),
        (PLAIN.replace(b"Fy", b"Fx"), {}, "line 1: the column name 'Fx' occurs 2 times; give every column"),
        (PLAIN.replace(b"1.5", b"abc"), {}, "line 2, column Fx: 'abc' is not a number"),
        (PLAIN.replace(b"1.5", b""), {}, "line 2, column Fx: the cell is empty"),
        (PLAIN.replace(b"1.5", b"nan"), {}, "line 2, column Fx: 'nan' is not a finite number"),
        (PLAIN.replace(b"1.5", b"-inf"), {}, "line 2, column Fx: '-inf' is not a finite number"),
        (PLAIN.replace(b"1.5", b"1e999"), {}, "line 2, column Fx: '1e999' is too large"),
        (PLAIN.replace(b"1.5,", b""), {}, "line 2: 2 cells, the header has 3"),
        (PLAIN.replace(b"4\n", b"4,5\n"), {}, "line 3: 4 cells, the header has 3; log again"),
        (PLAIN + b"Channels,3,\nSamples,2,2\n" + PLAIN, {}, "line 4: a second segment"),
        (PLAIN.replace(b".", b","), {}, "decimal commas need another delimiter"),
        (
            PLAIN.replace(b",", b";").replace(b".", b","),
            {"decimal": "."},
            "line 2, column t: '0,0' has a decimal mark other than '.'; set",
        ),
        (PLAIN.replace(b",", b";"), {"decimal": ","}, "has a decimal mark other than ','; set csv.decimal = \".\""),
        (
            PLAIN.replace(b",", b";") + b"0.2;1,5;3\n",
            {},
            "line 4, column Fx: '1,5' has a decimal mark other than '.'; correct the cell",
        ),
        (b"PK\x03\x04" + bytes(range(256)), {}, "an archive of files, no log; unpack it"),
        (PLAIN.decode().encode("utf-16")[:-1], {}, "the file is cut off in the middle of a character"),
        (PLAIN.replace(b"1.5", b"1 5000.0"), {}, "line 2, column Fx: '1 5000.0' is not a number"),
        (
            PLAIN.replace(b"1.5", b"1'500.0").replace(b"+3e2", b"1 500.0"),
            {},
            'line 2, column Fx: "1\'500.0" has thousands separators',
        ),
        (PLAIN + PLAIN, {}, "line 4, column t: the header is repeated here ('t')"),
        (PLAIN[:-10], {}, "line 3: the file is cut off in the middle of a line (1 of 3 cells)"),
        (PLAIN[:-3], {}, "line 3: the file is cut off in the middle of a line (2 of 3 cells)"),
        (PLAIN[:-2], {}, "line 3, column Fy: the file is cut off in the middle of a line ('')"),
        (b"t,Fx,Fy\n0,1,2.125\n0,1,2.1", {}, "last line, column Fy: the file ends without a line end after '2.1'"),
        (b"t,Fx,Fy\n0,1,100\n0,1,10", {}, "it may be cut off in the middle of a number"),
        (b't,Fx,Fy,note\n0,1,2,"a\n3,4,5,b"\n6,7,8,c\n', {}, "line 2: a quotation mark is not closed"),
        (PLAIN + b"\0\0\0\0\0\0", {}, "line 4: the line contains NUL bytes: writing the log was interrupted"),
        (
            PLAIN.replace(b"1.5", b'"1.5'),
            {},
            "line 2: a quotation mark is not closed",
        ),
        (
            PLAIN.decode().encode("utf-16"),
            {"encoding": "latin-1"},
            'line 1: the line contains bytes that are not text (NUL); set csv.encoding = "utf-16"',
        ),
        (PLAIN.replace(b"Fx", b"\xb5"), {"encoding": "utf-8"}, "line 1: byte 0xb5 is not utf-8; set csv.encoding"),
        (PLAIN, {"encoding": "klingon"}, "csv.encoding: no encoding 'klingon'"),
        (PLAIN, {"delimeter": ","}, "csv.delimeter: no such option; did you mean csv.delimiter?"),
        (PLAIN, {"delimiter": ",,"}, "csv.delimiter: ',,' is not a valid single character"),
        (PLAIN, {"decimal": "'"}, 'csv.decimal: "\'" is not a decimal mark'),
        (PLAIN, {"skip_rows": True}, "csv.skip_rows: True is not a whole number"),
        *((packed[:-12], {}, "the compressed file is damaged or cut off") for packed in PACKED.values()),
    ],
)
def test_faults_are_one_clear_line(content: bytes, options: dict[str, Any], expected: str) -> None:
    with pytest.raises(InputError) as caught:
        read(content, **options)
    assert expected in str(caught.value.faults[0])


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"raw/ft\.csv: cannot be read: No such file"):
        list(READER.read_batches(tmp_path / "ft.csv", {}, WANTED, "raw/ft.csv"))


def test_a_last_line_without_end_is_read_where_nothing_can_be_missing() -> None:
    assert read(b"t,Fx,Fy\n0,1,2.125\n0,1,2.250")["Fy"].tolist() == [2.125, 2.25]
    assert read(b"t,Fx,Fy,note\n0,1,2,a\n0,1,20,b")["Fy"].tolist() == [2, 20]


def test_a_column_of_its_own_file() -> None:
    wanted = WantedColumns(("x",))
    assert read(b"x\n1\n2\n\n\n", wanted)["x"].tolist() == [1, 2]
    assert "line 3, column x: the cell is empty" in fault(b"x\n1\n\n2\n", wanted)


@pytest.mark.parametrize("block", [64, 100, 257])
def test_blocks_do_not_matter(monkeypatch: pytest.MonkeyPatch, block: int) -> None:
    monkeypatch.setattr(csv_module, "BLOCK", block)
    values = np.random.default_rng(block).normal(size=(200, 3)).round(4)
    lines = [b",".join(b"%.4f" % value for value in row) for row in values]
    content = b"t,Fx,Fy\r\n" + b"".join(
        line + (b"\r\n\r\n" if number % 7 == 0 else b"\r\n") for number, line in enumerate(lines)
    )
    found = read(content)
    assert np.array_equal(np.column_stack([found[name] for name in COLUMNS]), values)
    broken = content.replace(lines[150], lines[150] + b"x")
    line = 2 + 150 + sum(number % 7 == 0 for number in range(150))
    assert f"line {line}, column Fy: " in fault(broken)


def test_a_stray_mark_at_the_border_of_two_blocks_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_module, "BLOCK", 64)
    for width in range(1, 20):
        filler = b"0.5," + b"1" * width + b",2\n"
        content = b"t,Fx,Fy\n" + 3 * filler + b'0.6,"1"2,3\n' + 3 * filler
        assert "line 5: a quotation mark is not closed" in fault(content)


def test_reading_may_stop_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(b"t,Fx,Fy\n" + b"0.5,1.25,-3\n" * 1_500_000)
    for _ in range(5):
        for batch in READER.read_batches(path, {}, WANTED):
            assert len(batch) > 1000
            break


# ---- hostile logs: the same numbers or a fault, never other numbers -----------------------------------------------


VALUES = np.array([[0.0, 1.5, -22.75], [0.1, 150.25, 4.0], [0.2, -3.125, 1e-05], [0.3, 7.0, 123456.5]])


def written(delimiter: str, decimal: str) -> bytes:
    rows = [delimiter.join(repr(float(value)) for value in row).replace(".", decimal) for row in VALUES]
    return "\n".join([delimiter.join(COLUMNS), *rows, ""]).encode()


def outcome(content: bytes, **options: Any) -> tuple[dict[str, NDArray[Any]], str]:
    try:
        return read(content, **options), ""
    except InputError as error:
        return {}, str(error.faults[0])


def check_same_or_fault(content: bytes, **options: Any) -> None:
    found, error = outcome(content, **options)
    if error:
        assert "\n" not in error
        assert "after data row" not in error, f"the slow pass found nothing: {error}"
        return
    table = np.column_stack([found[name] for name in COLUMNS])
    assert np.array_equal(table, VALUES[: len(table)])


styles = st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", ",")])


@settings(max_examples=60)
@given(style=styles, cut=st.integers(0, 90))
def test_a_log_cut_anywhere(style: tuple[str, str], cut: int) -> None:
    content = written(*style)
    check_same_or_fault(content[:cut], decimal=style[1])


HOSTILE = rb"""
 |nan|NaN|inf|-|--|#N/A|null|1e|0x1p3|1_0|1 0|1,0|1.0.0|1.234,5|1,234.5|1'0|"|"1|1"|"1"2|5%|5N|(5)|=5|1e400|-1e400
12:30|True|ERR|Fx|infinity|nan(0)|1d3|''|1e5e5|+|+-5|e5|.|,|;|1 "2"|""1""
"""
CELLS = [cell for line in HOSTILE.strip(b"\n").split(b"\n") for cell in line.split(b"|")]
hostile = st.sampled_from(
    [
        *CELLS,
        b"",
        b"\0",
        b"\xb5",
        b"\xff",
        b"\xe2\x88\x925",
        b"\xc2\xa05",
        b"5\xc2\xa0",
        b"\x1a",
        b"\t",
        b"\xef\xbb\xbf5",
    ]
)


@settings(max_examples=80)
@given(style=styles, row=st.integers(0, 3), column=st.integers(0, 2), cell=hostile)
def test_a_hostile_cell(style: tuple[str, str], row: int, column: int, cell: bytes) -> None:
    lines = written(*style).split(b"\n")
    cells = lines[row + 1].split(style[0].encode())
    cells[column] = cell
    lines[row + 1] = style[0].encode().join(cells)
    found, error = outcome(b"\n".join(lines), decimal=style[1], delimiter=style[0])
    if error:
        assert f"line {row + 2}" in error
    else:
        # What is still a number has to be the one that stands there.
        number = cell.decode("utf-8", "replace").replace("1,234.5" if style[1] == "." else "1.234,5", "1234.5")
        number = number.replace(style[1], ".").replace("\u2212", "-")
        assert found[COLUMNS[column]][row] == float(number.strip(' "\ufeff'))


edits = st.lists(
    st.tuples(
        st.integers(0, 200),
        st.sampled_from(
            [
                b"\n",
                b"\r",
                b"\r\n",
                b",",
                b";",
                b'"',
                b'"\n',
                b"\0",
                b" ",
                b"\t",
                b"\n\n",
                b"x",
                b"\xff",
                b"\nt,Fx,Fy\n",
                b"\n;;\n",
            ]
        ),
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=100)
@given(style=styles, edits=edits, crlf=st.booleans())
@example(style=(";", "."), edits=[(20, b'"'), (40, b'"')], crlf=False)
def test_hostile_insertions(style: tuple[str, str], edits: list[tuple[int, bytes]], crlf: bool) -> None:
    """Bytes that carry no digits, anywhere: a line cut in two, a stray quotation mark, NULs, a repeated header."""
    content = written(*style)
    if crlf:
        content = content.replace(b"\n", b"\r\n")
    # Not inside a number, where a line end or delimiter makes two good numbers of one: only cell borders are hurt.
    for position, junk in edits:
        borders = [index for index, byte in enumerate(content) if byte in b"\n" + style[0].encode()]
        at = borders[position % len(borders)]
        content = content[:at] + junk + content[at:]
    check_same_or_fault(content, decimal=style[1], delimiter=style[0])


@settings(max_examples=60)
@given(
    values=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20),
    delimiter=st.sampled_from(",;\t| "),
    encoding=st.sampled_from(["utf-8", "latin-1", "cp1252", "utf-16", "utf-8-sig"]),
)
def test_every_float_comes_back_exactly(values: list[float], delimiter: str, encoding: str) -> None:
    content = "".join(["t", delimiter, "Fx\n", *(f"{value!r}{delimiter}{value:.17e}\n" for value in values)])
    found = read(content.encode(encoding), WantedColumns(("t", "Fx")), delimiter=delimiter, encoding=encoding)
    assert found["t"].tolist() == values
    assert found["Fx"].tolist() == values


def test_a_scope_export_with_a_time_column_per_channel(tmp_path: Path) -> None:
    path = tmp_path / "scope.csv"
    rows = [
        *("Name\tYT Scope", "Starttime of export\t134082189300000000", "", "Name\tFx\tName\tFy\tFz"),
        *("Unit\tN (Newton)\tUnit\t(None)\tkN", "SampleTime[ms]\t1\tSampleTime[ms]\t2\t2", ""),
        *("0\t1,5\t0\t2,5\t3", "1\t1,25\t2\t2,25\t4", ""),
    ]
    path.write_text("\n".join(rows), encoding="utf-8")
    options: dict[str, object] = {"delimiter": "tab", "decimal": ",", "skip_rows": 3}
    header = READER.read_header(path, options)
    assert header.columns == ("time Fx", "Fx", "time Fy", "Fy", "Fz")
    assert header.units == {"time Fx": "ms", "time Fy": "ms", "Fx": "N", "Fz": "kN"}
    wanted = WantedColumns(("time Fy", "Fy", "Fz"))
    (batch,) = READER.read_batches(path, options, wanted)
    assert {name: values.tolist() for name, values in batch.numbers.items()} == {
        "time Fy": [0.0, 2.0],
        "Fy": [2.5, 2.25],
        "Fz": [3.0, 4.0],
    }
    assert READER.place_of_row(path, options, 2) == "line 9"
    path.write_text("\n".join([*rows[:-1], "EOF", ""]), encoding="utf-8")
    with pytest.raises(InputError, match="line 10: the export marks its end; export without the EOF tag"):
        list(READER.read_batches(path, options, wanted))


def test_no_reading_goes_on_after_a_log_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The parser reads ahead in a thread; Python ending in the middle of that would abort the process."""
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(("t,Fx\n" + "0.001,1\n" * 20_000).encode()))
    under_way: list[int] = []
    read = LogText._read

    def slow(text: LogText, size: int) -> bytes:
        under_way.append(1)
        time.sleep(0.05)
        under_way.pop()
        return read(text, size)

    monkeypatch.setattr(LogText, "_read", slow)
    monkeypatch.setattr(csv_module, "BLOCK", 1 << 12)
    batches = iter(READER.read_batches(path, {}, WantedColumns(("t", "Fx"))))
    next(batches)
    batches.close()  # type: ignore[attr-defined]
    assert not under_way
    time.sleep(0.12)
    assert not under_way


def test_all_rows_of_words_below_a_table_are_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,Fx\n" + "".join(f"{k},{k}.5\n" for k in range(6)) + "mean,2.5\nmax,5.5\n", "utf-8")
    with pytest.raises(InputError) as caught:
        read_columns(find_reader(path), path, {}, WantedColumns(("t", "Fx")))
    assert "rows = [7, 8]" in caught.value.faults[0].mend
    assert "line 8" in caught.value.place
