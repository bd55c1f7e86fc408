"""The numbers that decide in the reduction of logs and in the search for mistakes: names, values, reasons."""

from __future__ import annotations

import ast
import importlib
import io
import math
import tokenize
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).parents[2] / "stiffcal"
ROOMS = (
    "reduction",
    "mistakes",
    "kinds/friction/logs/clocks.py",
    "kinds/clamped/logs/clocks.py",
    "kinds/clamped/held/holding.py",
)
"""Where they stand: holds and clocks of all kinds of experiment as well."""

FIXED: Mapping[str, str] = {
    "STANDARD_GRAVITY": "defined",
    "TURN": "defined",
    "GOLDEN": "the golden section",
    "KGF": "defined",
    "LBF": "defined",
    "INCH": "defined",
    "FOOT": "defined",
    "HOUR_S": "defined",
    "DAY_S": "defined",
    "ENDS": "ends of integers",
    "WHOLE": "a mark",
    "UNLOADED": "a name",
    "LOADING": "a name",
    "PEAK": "a name",
    "UNLOADING": "a name",
    "SECOND_DIFFERENCE": "statistics",
    "FOURTH_DIFFERENCE": "statistics",
    "UNIFORM": "statistics",
    "QUARTER": "statistics",
    "FIRST_QUARTILE": "statistics",
    "MEDIAN_OF_DIFFERENCES": "statistics",
    "KILO": "defined",
    "TURNS": "defined",
    "NUMBERS": "defined",
    "QUARTERS": "defined",
    "_COUNTED": "defined",
    "_DIFFERENCES": "defined",
    "_OF_ONE_AXIS": "defined",
    "LEAST_NOISE_OF_LOAD": "a guard against rounding",
    "LEAST_LEFT": "a guard against rounding",
    "OF_STILL_TERM": "a guard against rounding",
    "OF_STILL_COLUMN": "a guard against rounding",
    "OF_STILL_COMPONENT": "a guard against rounding",
    "RANK": "a guard against rounding",
    "ROUNDING": "a guard against rounding",
    "_ROUNDING": "a guard against rounding",
    "_ROUNDED": "a guard against rounding",
    "MOST_LISTED": "how many are printed",
    "MOST_EXCLUDED": "how many are printed",
    "AT_ONCE": "memory",
    "_ROWS_AT_ONCE": "memory",
    "MOST_NAMED": "how many are printed",
    "MOST_GAPS": "how many are printed",
    "MOST_STRETCHES": "how many are printed",
    "RUNS_AT_ONCE": "memory",
    "CHUNK": "memory",
    "MOST_IN_TABLE": "speed",
}
"""Numbers that decide nothing, and what they are."""
GUARD = 1e-11
"""A number below it keeps a division from having nothing below the line."""
COSINES = frozenset({"SAME_DIRECTION"})
"""Numbers that are an angle's cosine: the angle is varied."""


@dataclass(frozen=True)
class Number:
    """One named number."""

    module: str
    """Of the package, as imported."""
    name: str
    """Its name."""
    value: Any
    """A number, or a tuple of them."""
    reason: str
    """What is written at it."""

    @property
    def place(self) -> str:
        """File and name, as the table has them."""
        return f"{self.module.removeprefix('stiffcal.').replace('.', '/')}.{self.name}"

    def times(self, factor: float) -> Any:
        """Return it varied; a count by one at least."""
        if self.name in COSINES:
            return math.cos(factor * math.acos(self.value))
        if isinstance(self.value, tuple):
            return tuple(_times(part, factor) for part in self.value)
        return _times(self.value, factor)


def _times(value: Any, factor: float) -> Any:
    if 0.8 < value < 1.0:
        # a share that leaves little: what it leaves is varied, as there is no larger one than all
        return 1.0 - (2.0 - factor) * (1.0 - value)
    if isinstance(value, int):
        moved = round(value * factor)
        return moved if moved != value else value + (1 if factor > 1.0 else -1)
    return value * factor


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        return bool(value) and all(_is_number(part) and not isinstance(part, tuple) for part in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def numbers() -> Iterator[Number]:
    """Give all of them that are no definitions, in the order of files and lines."""
    for file in files_of(*ROOMS):
        yield from of_file(file)


def files_of(*rooms: str) -> Iterator[Path]:
    """Give the files of folders and files of the package."""
    for room in rooms:
        path = PACKAGE / room
        yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]


def unnamed(text: str) -> list[str]:
    """Return the numbers inside a module's functions that may decide: a share, a count above three.

    Halves, doubles, guards against a division by nothing and digits that are printed are none.
    """
    found: list[tuple[int, str]] = []
    for function in [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]:
        printed = [
            argument
            for node in ast.walk(function)
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "significant"
            for argument in node.args
        ]
        for node in ast.walk(function):
            if not isinstance(node, ast.Constant) or node in printed:
                continue
            value = node.value
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            if not (value in (0.5, 1.0, 2.0) or value < GUARD or (isinstance(value, int) and value <= 3)):
                found.append((node.lineno, f"{value} in {function.name}, line {node.lineno}"))
    return [line for _, line in sorted(set(found))]


def of_file(file: Path) -> Iterator[Number]:
    """Give the named numbers of one file."""
    name = ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")
    text = file.read_text(encoding="utf-8")
    comments = _comments(text)
    body = ast.parse(text).body
    for k, node in enumerate(body):
        targets = node.targets if isinstance(node, ast.Assign) else []
        found = [one.id for target in targets for one in ast.walk(target) if isinstance(one, ast.Name)]
        for constant in found:
            value = getattr(importlib.import_module(name), constant)
            if constant.isupper() and constant not in FIXED and _is_number(value):
                yield Number(name, constant, value, _reason(body, k, comments))


def _comments(text: str) -> dict[int, str]:
    """Return by line what is written there in a comment."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return {token.start[0]: token.string.lstrip("# ") for token in tokens if token.type == tokenize.COMMENT}


def _reason(body: list[ast.stmt], k: int, comments: Mapping[int, str]) -> str:
    """Return what stands at an assignment: in a comment on its line, in a string after it, in comments above it.

    A string holds for all assignments that follow each other without a gap before it, comments for those after them.
    """
    line = body[k].lineno
    if line in comments:
        return comments[line]
    for after in body[k + 1 :]:
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            return " ".join(str(after.value.value).split())
        if not isinstance(after, ast.Assign) or after.lineno in comments or after.lineno - 1 in comments:
            break
    above = k
    while above and isinstance(body[above - 1], ast.Assign) and body[above - 1].end_lineno == body[above].lineno - 1:
        above -= 1
    lines, at = list[str](), body[above].lineno - 1
    while at in comments:
        lines.insert(0, comments[at])
        at -= 1
    return " ".join(lines)
