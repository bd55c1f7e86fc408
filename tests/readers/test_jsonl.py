"""JSON lines: a column is a path, a line a row; what is not whole or not clear is refused with its line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns

ROWS: list[dict[str, Any]] = [
    {"t": 0, "ft": {"force": [1.5, -2.0]}, "run": "a", "when": "2026-11-20T10:00:00Z", "seen": None},
    {"t": 0.1, "ft": {"force": [2.5, -3.0]}, "run": 2, "when": "2026-11-20T10:00:01Z", "seen": 1.0, "late": 5},
    {"t": 0.2, "ft": {"force": [3.5, -4.0]}, "run": "b", "when": "2026-11-20T10:00:02Z"},
]


def written(path: Path, *lines: object) -> Path:
    texts = (line if isinstance(line, str) else json.dumps(line) for line in lines)
    path.write_text("\n".join(texts) + "\n", encoding="utf-8")
    return path


def read(path: Path, wanted: WantedColumns) -> dict[str, Any]:
    return read_columns(find_reader(path), path, {}, wanted, "raw/log")


def fault(path: Path, wanted: WantedColumns) -> tuple[FaultCode, str]:
    with pytest.raises(InputError) as caught:
        read(path, wanted)
    assert "\n" not in str(caught.value)
    return caught.value.code, caught.value.place


def test_paths_are_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 2)
    path = written(tmp_path / "log.jsonl", ROWS[0], "", *ROWS[1:])
    columns = find_reader(path).read_header(path, {}).columns
    assert columns == ("t", "ft.force[0]", "ft.force[1]", "run", "when", "seen", "late")
    found = read(path, WantedColumns(("t", "ft.force[1]", "seen"), ("run",), ("when",), frozenset(("seen",))))
    assert found["ft.force[1]"].tolist() == [-2.0, -3.0, -4.0]
    assert found["run"].tolist() == ["a", "2", "b"]
    assert np.isnan(found["seen"]).tolist() == [True, False, True]
    assert np.diff(found["when"]).tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ('{"t": 1, "t": 2}', FaultCode.KEY_CONFLICT), ("[1, 2]", FaultCode.SYNTAX_INVALID),
        ("t,Fx", FaultCode.SYNTAX_INVALID), ('{"t": 1,}', FaultCode.SYNTAX_INVALID),
        ('{"t": NaN}', FaultCode.NUMBER_INVALID), ('{"t": true}', FaultCode.NUMBER_INVALID),
        ('{"t": 1e999}', FaultCode.NUMBER_INVALID), ('{"t": ' + "9" * 400 + "}", FaultCode.NUMBER_INVALID),
        ('{"t": ' + "9" * 5000 + "}", FaultCode.SYNTAX_INVALID), ('{"x": 1}', FaultCode.CELL_EMPTY),
        ('{"t": "three"}', FaultCode.NUMBER_INVALID), ('{"t": ' * 100_000, FaultCode.SYNTAX_INVALID),
    ],
)  # fmt: skip
def test_faults_have_their_line(tmp_path: Path, line: str, code: FaultCode) -> None:
    path = written(tmp_path / "log.jsonl", {"t": 0.5}, line)
    found, place = fault(path, WantedColumns(("t",)))
    assert found == code
    assert place.startswith("line 2")


def test_a_line_that_is_cut_off_and_an_empty_file(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text('{"t": 1}\n{"t": 2, "Fx', encoding="utf-8")
    assert fault(path, WantedColumns(("t",)))[0] == FaultCode.FILE_INCOMPLETE
    path.write_text("\n\n", encoding="utf-8")
    assert fault(path, WantedColumns(("t",)))[0] == FaultCode.FILE_EMPTY


COLUMNS = {"t": [0.0, 0.1, 0.2], "ft": {"F": [1.5, 2.5, 3.5]}}
OBJECTS = [{"t": t, "ft": {"F": f}} for t, f in zip(COLUMNS["t"], [1.5, 2.5, 3.5], strict=True)]
DOCUMENTS = {
    "a list of objects": OBJECTS,
    "columns": COLUMNS,
    "columns and what is stated about them": {"rate": 10, "samples": OBJECTS},
    "pandas, split": {"columns": ["t", "ft.F"], "index": [0, 1, 2], "data": [[0.0, 1.5], [0.1, 2.5], [0.2, 3.5]]},
    "pandas": {"t": {"0": 0.0, "1": 0.1, "2": 0.2}, "ft.F": {"0": 1.5, "1": 2.5, "2": 3.5}},
}


@pytest.mark.parametrize("document", DOCUMENTS)
@pytest.mark.parametrize("indent", [None, 2])
@pytest.mark.parametrize("name", ["log.json", "log.log"])
def test_a_document_that_holds_a_table_is_read(tmp_path: Path, document: str, indent: int | None, name: str) -> None:
    path = tmp_path / name
    path.write_text(json.dumps(DOCUMENTS[document], indent=indent), encoding="utf-8")
    found = read(path, WantedColumns(("t", "ft.F")))
    assert found["t"].tolist() == [0.0, 0.1, 0.2]
    assert found["ft.F"].tolist() == [1.5, 2.5, 3.5]


@pytest.mark.parametrize(
    "text", ['[{"t": 1}, 2]', '{"t": [1, 2], "F": [1]}', '[{"t": 1', '[{"t": 1}, {"t": 1, "t": 2}]', '{"a": {"b": {}}}']
)
def test_a_document_that_holds_none_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "log.json").write_text(text, encoding="utf-8")
    code, _ = fault(tmp_path / "log.json", WantedColumns(("t",)))
    assert code in (FaultCode.SYNTAX_INVALID, FaultCode.KEY_CONFLICT, FaultCode.COLUMN_MISSING)
