"""Texts for people are written and shown: nothing in the code compares them, searches them or cuts them."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXTS = frozenset(
    {"reason", "reasons", "remark", "remarks", "why", "mend", "warning", "warnings", "message", "note", "notes"}
)
LABELS = frozenset({"label", "title", "heading", "sentence", "words"})
"""Texts that may be keys, but are not taken apart either."""
SEARCHING = frozenset(
    {"startswith", "endswith", "split", "rsplit", "partition", "rpartition", "removeprefix", "removesuffix", "find",
     "index", "rfind", "rindex", "count", "replace"}
)  # fmt: skip
KEEPING = frozenset({"setdefault", "get", "pop"})
"""Methods whose first argument is a key: what has the same text is not the same case."""
PATTERNS = frozenset({"search", "match", "fullmatch", "findall", "finditer", "sub", "split"})
CHANGING = frozenset({"lower", "upper", "strip", "lstrip", "rstrip", "casefold"})
# `trust --revoke` takes what it prints of an entry: the note is a name there.
# `not_checked` takes the text of an enumeration's member that is called reason.
ALLOWED = {"stiffcal/trust/record.py": 1}


def held_in(node: ast.expr) -> str:
    """Return the name of the variable, attribute or key that an expression reads; "" for others."""
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name
        case ast.Subscript(slice=ast.Constant(value=str(key))):
            return key
        case ast.Subscript(value=value):
            return held_in(value)
        case ast.Call(func=ast.Attribute(attr="get"), args=[ast.Constant(value=str(key)), *_]):
            return key
        case ast.Call(func=ast.Name(id="str"), args=[value]):
            return held_in(value)
        case ast.Call(func=ast.Attribute(value=value, attr=name)) if name in CHANGING:
            return held_in(value)
    return ""


def is_text(node: ast.expr) -> bool:
    return held_in(node) in TEXTS


def asks_whether_there_is_one(sides: list[ast.expr]) -> bool:
    return any(isinstance(side, ast.Constant) and side.value in (None, "") for side in sides)


def is_member(node: ast.expr) -> bool:
    """Whether an expression is a member of an enumeration: what is compared with it is no text."""
    return isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id[:1].isupper()


def searched(tree: ast.AST) -> Iterator[ast.expr]:
    """Yield the expressions that compare, search or cut a text for people."""
    for node in ast.walk(tree):
        match node:
            case ast.Compare(left=left, comparators=others):
                sides = [left, *others]
                if any(map(is_text, sides)) and not (asks_whether_there_is_one(sides) or any(map(is_member, sides))):
                    yield node
            case ast.Call(func=ast.Attribute(value=value, attr=name), args=arguments):
                if name in SEARCHING and held_in(value) in TEXTS | LABELS:
                    yield node
                asked = arguments if name in PATTERNS else arguments[:1] if name in KEEPING else []
                if any(map(is_text, asked)):
                    yield node
            case ast.Subscript(value=value, slice=ast.Slice()) if is_text(value):
                yield node
            case ast.Subscript(slice=key) if is_text(key):
                yield node


def test_no_text_for_people_is_compared_searched_or_cut() -> None:
    found = []
    for file in sorted((ROOT / "stiffcal").rglob("*.py")):
        name = file.relative_to(ROOT).as_posix()
        places = [f"{name}:{node.lineno}" for node in searched(ast.parse(file.read_text(encoding="utf-8")))]
        found += places[ALLOWED.get(name, 0) :]
    assert found == []


@pytest.mark.parametrize(
    "code",
    [
        'still = "stands still" in remark',
        'missing = fault.reason == "no such file"',
        'bumped = state["why"].startswith("bumped")',
        'first = error.faults[0].reason.partition(": ")[0]',
        'lost = re.search("lost", entry.get("note", ""))',
        'low = "declare" in str(reason).lower()',
        "short = message[:10]",
        "count[stretch.reason] += 1",
        'joint = part.label.partition(":")[0]',
        "alike = groups.setdefault(state.why, [])",
    ],
)
def test_the_rule_finds(code: str) -> None:
    assert list(searched(ast.parse(code)))


@pytest.mark.parametrize(
    "code",
    [
        'if reason == "":\n    pass',
        "shown = f'{place}: {reason}'",
        "none = why is None",
        "few = lost.reason is Reason.FEW",
    ],
)
def test_the_rule_lets_pass(code: str) -> None:
    assert not list(searched(ast.parse(code)))
