"""One 95 % quantile in the whole package: no file writes 1.96 of its own."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_no_file_writes_a_quantile_of_its_own() -> None:
    found = [
        f"{file.relative_to(ROOT).as_posix()}:{node.lineno}"
        for file in sorted((ROOT / "stiffcal").rglob("*.py"))
        if file.name != "uncertainty.py"
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, float) and abs(node.value - 1.96) < 1e-3
    ]
    assert found == []
