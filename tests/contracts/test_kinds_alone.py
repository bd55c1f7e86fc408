"""What differs between kinds of experiment stands in their folders: no other file asks for one by its name."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import stiffcal
from stiffcal.campaign.found.experiment_kinds import kind_names

PACKAGE = Path(stiffcal.__file__).parent
NAMES = frozenset(kind_names())
MAY_NAME_ONE = rf"""["']({"|".join(NAMES)})["']|stiffcal.kinds"""
# `plan.toml` names what is planned, three kinds of run whatever kinds of experiment there are, and `init --kind` drafts
# campaigns of two from their logs.
PLANS = (
    "planning/", "stages/plans/", "commands/plan.py", "show/answers/plan.py", "campaign/plan_file.py",
    "report/run_sheet.py",
)  # fmt: skip
DRAFTS = ("propose/", "commands/init.py", "cli/init.py")


def test_no_other_room_asks_for_a_kind_by_its_name() -> None:
    found: dict[str, list[int]] = {}
    for path in PACKAGE.rglob("*.py"):
        place, text = path.relative_to(PACKAGE).as_posix(), path.read_text(encoding="utf-8")
        if place.startswith(("kinds/", *PLANS, *DRAFTS)) or not re.search(MAY_NAME_ONE, text):
            continue
        if lines := kinds_named(text):
            found[place] = lines
    assert found == {}


def test_a_name_in_an_import_a_comparison_and_a_table_is_found() -> None:
    text = """from stiffcal.kinds.load import KIND
from stiffcal.kinds import all_kinds, load
held = run.experiment in ("load", "x")
LOAD, CLAMPED = "load", "clamped"
"""
    assert kinds_named(text) == [1, 2, 3, 4]


def kinds_named(text: str) -> list[int]:
    """Return the lines in which a module names a kind: in an import, in a comparison, or in a table that it keeps.

    The name "load" has other meanings: it counts where an experiment or a kind is compared with it.
    """
    lines: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            parts = [*(node.module or "").split("."), *(alias.name for alias in node.names)]
            if parts[:2] == ["stiffcal", "kinds"] and NAMES.intersection(parts[2:]):
                lines.add(node.lineno)
        elif isinstance(node, ast.Compare):
            if texts_in(node) & NAMES and re.search("experiment|kind", ast.unparse(node)):
                lines.add(node.lineno)
        elif isinstance(node, ast.Assign | ast.AnnAssign) and not isinstance(node.value, ast.Call):
            kept = node.value is not None and not any(isinstance(one, ast.Compare) for one in ast.walk(node.value))
            if kept and texts_in(node) & (NAMES - {"load"}):
                lines.add(node.lineno)
    return sorted(lines)


def texts_in(node: ast.AST) -> set[str]:
    """Return the texts in an expression."""
    return {one.value for one in ast.walk(node) if isinstance(one, ast.Constant) and isinstance(one.value, str)}
