"""Programs and the documentation go by the codes of faults: each is used, described, and shown wherever a fault is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode

PACKAGE = Path(__file__).parents[1] / "stiffcal"


def test_a_code_is_in_kebab_case_and_covers_one_sentence() -> None:
    for code in FaultCode:
        assert re.fullmatch(r"[a-z]+(-[a-z]+)+", code.value)
        assert code.name == code.value.upper().replace("-", "_")
        assert re.fullmatch(r"[A-Z][^\n]+\.", code.covers)


def test_every_code_is_used() -> None:
    texts = [file.read_text("utf-8") for file in PACKAGE.rglob("*.py") if file.name != "fault_codes.py"]
    used = set(re.findall(r"FaultCode\.([A-Z_]+)", "\n".join(texts)))
    assert {code.name for code in FaultCode} == used


@pytest.mark.parametrize("file", ["", "campaign.toml"])
def test_the_code_stands_at_the_end_of_the_line_and_first_in_the_document(file: str) -> None:
    fault = Fault(FaultCode.UNIT_UNKNOWN, file, "", "no unit", "write mm")
    assert str(fault).endswith("no unit; write mm [unit-unknown]")
    assert next(iter(fault.as_document().items())) == ("code", "unit-unknown")


def test_an_error_has_the_parts_of_its_first_fault() -> None:
    first, second = (Fault(code, "a", "b", "c", "d") for code in (FaultCode.CELL_EMPTY, FaultCode.NO_BALANCE))
    error = InputError(first, second)
    assert (error.code, error.file, error.place, error.reason, error.mend) == ("cell-empty", "a", "b", "c", "d")
