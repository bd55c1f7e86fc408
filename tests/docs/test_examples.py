"""The examples of troubleshooting are sentences that the program can say."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from docs.page_blocks import page_text
from tests.laboratory.documentation import ROOT

LETTERS = 6
NOT_OURS = {"command-line"}
"""Codes whose sentences are those of a library."""


def sentences() -> Iterator[tuple[str, str]]:
    """Yield each text of the code: its longest fixed part, and its pattern, in which anything may be put in."""
    for file in (ROOT / "stiffcal").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
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


def test_each_example_is_a_sentence_of_the_code() -> None:
    examples = re.findall(
        r"^### (\S+)\n(?:(?!^###).*\n)*?\*\*Example:\*\* `([^`]+)`", page_text("troubleshooting.md"), flags=re.MULTILINE
    )
    known = list(sentences())
    assert len(examples) > 70
    unknown = {code: example for code, example in examples if code not in NOT_OURS and not is_said(example, known)}
    assert unknown == {}
