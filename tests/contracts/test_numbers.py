"""Every number that decides has a name and stands in one file."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "stiffcal"
NAMELESS = {-1, 0, 1, 2}
"""Signs, halves of pairs and what there is none, one or two of."""
UNDERFLOW = 1e-200
"""Below it a number keeps a division or a logarithm from zero."""


def numbers_in(node: ast.AST) -> Iterator[float]:
    """Give the literal numbers of an expression that decide something."""
    for part in ast.walk(node):
        value = part.value if isinstance(part, ast.Constant) else None
        if isinstance(value, int | float) and value not in NAMELESS and abs(value) > UNDERFLOW:
            yield value


def counts_axes(node: ast.AST) -> bool:
    """Return whether an expression is a length: of a vector, of a shape."""
    match node:
        case ast.Call(func=ast.Name(id="len")):
            return True
        case ast.Attribute(attr="ndim") | ast.Subscript(value=ast.Attribute(attr="shape")):
            return True
    return False


def decided_by_literals(tree: ast.AST) -> Iterator[tuple[int, float]]:
    """Give line and number of literals in comparisons."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            if not any(counts_axes(side) for side in sides):
                yield from ((node.lineno, number) for side in sides for number in numbers_in(side))


def constants_of(tree: ast.Module) -> Iterator[str]:
    """Give the names of a module's constants that are numbers."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(numbers_in(node.value)):
            yield from (name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name))


def trees(folder: str) -> Iterator[tuple[str, ast.Module]]:
    for path in sorted((PACKAGE / folder).rglob("*.py")):
        yield path.relative_to(PACKAGE).as_posix(), ast.parse(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("folder", ["judgement", "diagnosis"])
def test_no_comparison_has_a_number_without_a_name(folder: str) -> None:
    found = [f"{name}:{line}: {number}" for name, tree in trees(folder) for line, number in decided_by_literals(tree)]
    assert found == []


def test_numbers_of_the_judgement_stand_in_one_file() -> None:
    found = [f"{name}: {one}" for name, tree in trees("judgement") for one in constants_of(tree)]
    assert [one for one in found if not one.startswith("judgement/numbers.py")] == []


@pytest.mark.parametrize("code", ["x > 0.5", "0.1 < p < q", "3 * n > m", "x.sum() >= -4"])
def test_a_literal_that_decides_is_found(code: str) -> None:
    assert list(decided_by_literals(ast.parse(code)))


@pytest.mark.parametrize(
    "code", ["len(x) < 3", "x.shape[0] == 6", "x > 0.0", "n < 2", "v > NAMED", "x > max(y, 1e-300)"]
)
def test_lengths_signs_and_names_are_none(code: str) -> None:
    assert not list(decided_by_literals(ast.parse(code)))
