"""Rules for the text of the code, all files of which are parsed once.

- Texts for people are written and shown: nothing in the code compares them, searches them or cuts them.
- The examples of troubleshooting are sentences that the program can say.
- One 95 % quantile in the whole package: no file writes 1.96 of its own.
- One name, one meaning: no two public classes of the package have the same name.
- TOML that is printed parses, and names in it are quoted by `escapes.toml_text`.
"""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pytest

from docs.page_blocks import page_text
from tests.laboratory.printed_toml import pairs_in, printed_texts, wrong_toml

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
LETTERS = 6
NO_TOML = ("stiffcal/readers/postgres/__init__.py",)
"""Files whose `key = value` is SQL."""
NOT_OURS = {"command-line"}
"""Codes whose sentences are those of a library."""


@pytest.fixture(scope="module")
def nodes() -> Mapping[str, list[ast.AST]]:
    """All nodes of each file of the package, its module first."""
    files = sorted((ROOT / "stiffcal").rglob("*.py"))
    return {
        file.relative_to(ROOT).as_posix(): list(ast.walk(ast.parse(file.read_text(encoding="utf-8")))) for file in files
    }


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


def searched(nodes: Iterable[ast.AST]) -> Iterator[ast.expr]:
    """Yield the expressions that compare, search or cut a text for people."""
    for node in nodes:
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


def test_no_text_for_people_is_compared_searched_or_cut(nodes: Mapping[str, list[ast.AST]]) -> None:
    found = []
    for name, inside in nodes.items():
        found += [f"{name}:{node.lineno}" for node in searched(inside)][ALLOWED.get(name, 0) :]
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
    assert list(searched(ast.walk(ast.parse(code))))


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
    assert not list(searched(ast.walk(ast.parse(code))))


def sentences(nodes: Iterable[ast.AST]) -> Iterator[tuple[str, str]]:
    """Yield each text of the code: its longest fixed part, and its pattern, in which anything may be put in."""
    for node in nodes:
        parts = node.values if isinstance(node, ast.JoinedStr) else [node]
        fixed = [part.value if isinstance(part, ast.Constant) else None for part in parts]
        if isinstance(node, ast.JoinedStr | ast.Constant) and all(isinstance(text, str | None) for text in fixed):
            texts = [text if isinstance(text, str) else None for text in fixed]
            longest = max((text for text in texts if text), key=len, default="")
            if sum(len(text.strip()) for text in texts if text) >= LETTERS:
                yield longest, "".join(".+?" if text is None else re.escape(text) for text in texts)


def endings(example: str) -> list[str]:
    """Return a fault's line without its file, without its place too, and so on."""
    pieces = example.split(": ")
    return [": ".join(pieces[start:]) for start in range(len(pieces))]


def is_said(example: str, known: list[tuple[str, str]]) -> bool:
    """Whether a text of the code is what an example says."""
    likely = [pattern for longest, pattern in known if longest in example]
    return any(re.fullmatch(pattern, end) for pattern in likely for end in endings(example))


def test_each_example_of_troubleshooting_is_a_sentence_of_the_code(nodes: Mapping[str, list[ast.AST]]) -> None:
    examples = re.findall(
        r"^### (\S+)\n(?:(?!^###).*\n)*?\*\*Example:\*\* `([^`]+)`", page_text("troubleshooting.md"), flags=re.MULTILINE
    )
    known = [sentence for inside in nodes.values() for sentence in sentences(inside)]
    assert len(examples) > 70
    unknown = {code: example for code, example in examples if code not in NOT_OURS and not is_said(example, known)}
    assert unknown == {}


def test_no_file_writes_a_quantile_of_its_own(nodes: Mapping[str, list[ast.AST]]) -> None:
    found = [
        f"{name}:{node.lineno}"
        for name, inside in nodes.items()
        if name != "stiffcal/uncertainty.py"
        for node in inside
        if isinstance(node, ast.Constant) and isinstance(node.value, float) and abs(node.value - 1.96) < 1e-3
    ]
    assert found == []


def test_no_two_public_classes_have_the_same_name(nodes: Mapping[str, list[ast.AST]]) -> None:
    files: dict[str, list[str]] = defaultdict(list)
    for name, (module, *_) in nodes.items():
        assert isinstance(module, ast.Module)
        for node in module.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                files[node.name].append(name)
    assert {name: places for name, places in files.items() if len(places) > 1} == {}


def test_printed_toml_parses_and_names_are_quoted(nodes: Mapping[str, list[ast.AST]]) -> None:
    wrong, count = [], 0
    for name, inside in nodes.items():
        for line, text in printed_texts(inside) if name not in NO_TOML else ():
            if " = " in text:
                count += sum(1 for _ in pairs_in(text))
                wrong += [f"{name}:{line}: {piece}" for piece in wrong_toml(text)]
    assert not wrong, "\n".join(wrong)
    assert count > 100
