"""The examples in docstrings give what they print.

pytest's own collection of docstrings would import all modules in each of its processes; here a process imports those
whose examples it runs.
"""

from __future__ import annotations

import doctest
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLE = re.compile(rb"^\s*>>> ", re.MULTILINE)


def modules_with_examples() -> list[str]:
    """Return the dotted names of all modules with an example, tests and the documentation's tools included."""
    files = [file for folder in ("stiffcal", "tests", "docs") for file in sorted((ROOT / folder).rglob("*.py"))]
    with_example = [file.relative_to(ROOT) for file in files if EXAMPLE.search(file.read_bytes())]
    return [".".join(file.with_suffix("").parts).removesuffix(".__init__") for file in with_example]


@pytest.mark.parametrize("name", modules_with_examples())
def test_the_examples_of_a_module_hold(name: str) -> None:
    failed, tried = doctest.testmod(importlib.import_module(name))  # prints what differs
    assert tried > 0
    assert failed == 0
