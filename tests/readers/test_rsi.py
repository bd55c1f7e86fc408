"""Documents of KUKA's RobotSensorInterface: attributes by path, the controller's clock, no entities."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns

ROW = '<Rob TYPE="KUKA"><RIst X="1.0" A="0.5"/><AIPos A1="{angle}" A2="-90.0"/><Delay D="0"/><IPOC>{ms}</IPOC></Rob>'
WANTED = WantedColumns(("IPOC", "AIPos.A1"))


def rows(count: int = 5) -> list[str]:
    return [ROW.format(angle=0.5 * k - 1.0, ms=1000 + 4 * k) for k in range(count)]


def read(path: Path, wanted: WantedColumns) -> dict[str, Any]:
    return read_columns(find_reader(path), path, {}, wanted, "raw/log")


def fault(path: Path) -> tuple[FaultCode, str]:
    with pytest.raises(InputError) as caught:
        read(path, WANTED)
    assert "\n" not in str(caught.value)
    return caught.value.code, caught.value.place


@pytest.mark.parametrize("between", ["\n", "", "\r\n\r\n", '\n<?xml version="1.0"?>\n'])
def test_documents_are_rows(tmp_path: Path, between: str, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 2)
    path = tmp_path / "log.xml"
    path.write_text(between.join(rows()), encoding="utf-8")
    header = find_reader(path).read_header(path, {})
    assert header.columns == ("RIst.X", "RIst.A", "AIPos.A1", "AIPos.A2", "Delay.D", "IPOC")
    assert (header.units["IPOC"], header.units["AIPos.A1"], header.units["RIst.X"]) == ("ms", "deg", "mm")
    found = read(path, WANTED)
    assert found["IPOC"].tolist() == [1000.0, 1004.0, 1008.0, 1012.0, 1016.0]
    assert found["AIPos.A1"].tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0]


def test_its_content_tells_it_whatever_the_ending(tmp_path: Path) -> None:
    (tmp_path / "log.dump").write_text("\n".join(rows()), encoding="utf-8")
    assert find_reader(tmp_path / "log.dump").name == "rsi"


ENTITY = '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (ENTITY, FaultCode.SYNTAX_INVALID), (ENTITY + ROW.replace("{angle}", "&a;"), FaultCode.SYNTAX_INVALID),
        ("<Rob><AIPos A1='1'/>", FaultCode.FILE_INCOMPLETE), ("<Other/>", FaultCode.FORMAT_UNKNOWN),
        ("12:00 <Rob></Rob>", FaultCode.SYNTAX_INVALID),
        ("<Rob><IPOC>1</IPOC><IPOC>2</IPOC></Rob>", FaultCode.KEY_CONFLICT),
        ("<Rob><IPOC>1</IPOC></Rob>", FaultCode.CELL_EMPTY), (ROW.format(angle="x", ms=1), FaultCode.NUMBER_INVALID),
        ("</all>", FaultCode.SYNTAX_INVALID), ("</all><all>", FaultCode.SYNTAX_INVALID),
        ("<Rob>" * 100_000, FaultCode.SYNTAX_INVALID),
    ],
)  # fmt: skip
def test_faults_have_their_line(tmp_path: Path, line: str, code: FaultCode) -> None:
    path = tmp_path / "log.xml"
    path.write_text("\n".join([rows()[0], line]), encoding="utf-8")
    found, place = fault(path)
    assert found == code
    assert place.startswith("line 2")
