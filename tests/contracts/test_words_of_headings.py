"""Headings and columns of terminal, report, page and documentation use the glossary's words."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE, DOCS = ROOT / "stiffcal", ROOT / "docs"
HEADED = {
    "TableColumn",
    "Column",
    "ReportSection",
    "SubheadingBlock",
    "Subheading",
    "Panel",
    "Page",
    "plain_table",
    "LeftOut",
    "PageBuilder",
    "number",
    "wide",
}
"""What makes a heading or a column: the first text of its arguments, of `plain_table` all of them."""
BUILT = {"table", "head"}
"""Likewise of a page that is built block by block (`stiffcal.show.builder`)."""


def not_called() -> dict[str, str]:
    """Return each word that stands in no heading, with the entry of the glossary that replaces it."""
    found: dict[str, str] = {}
    for entry in (DOCS / "glossary.md").read_text(encoding="utf-8").split("\n\n"):
        for words in re.findall(r"Not called:\s([^.]*)\.", entry):
            found |= {word.strip(): entry.partition("\n")[0] for word in re.sub(r"\s+", " ", words).split(",")}
    return found


def headings() -> Iterator[tuple[str, str]]:
    """Yield place and text of each heading and column."""
    may_head = re.compile(rf"\b(?:{'|'.join(sorted(HEADED | BUILT))})\(|_TITLE")
    for file in sorted(PACKAGE.rglob("*.py")):
        source = file.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(source)) if may_head.search(source) else ():
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in HEADED:
                texts = node.args if node.func.id == "plain_table" else node.args[:1]
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in BUILT:
                texts = node.args[:1]
            elif isinstance(node, ast.Assign) and any(
                getattr(to, "id", "").startswith("_TITLE") for to in node.targets
            ):
                texts = [node.value]
            else:
                continue
            for text in texts:
                for part in ast.walk(text):
                    if isinstance(part, ast.Constant) and isinstance(part.value, str):
                        yield f"{file.relative_to(ROOT)}:{part.lineno}", part.value
    for file in sorted(PACKAGE.rglob("*.js")):
        for text in re.findall(r'\btitle: "([^"]*)"', file.read_text(encoding="utf-8")):
            yield str(file.relative_to(ROOT)), text
    written = (file for file in sorted(DOCS.rglob("*.md")) if "generated" not in file.parts)
    for file in (ROOT / "README.md", *written):
        for line in file.read_text(encoding="utf-8").splitlines():
            if re.match(r"#+ ", line):
                yield str(file.relative_to(ROOT)), line.strip("# ")


def test_headings_and_columns_use_the_words_of_the_glossary() -> None:
    replaced, found = not_called(), list(headings())
    assert len(replaced) >= 8
    assert len(found) > 300
    wrong = [
        f"{place}: {text!r}, write {entry}"
        for place, text in found
        for word, entry in replaced.items()
        if re.search(rf"\b{re.escape(word)}\b", text, re.IGNORECASE)
    ]
    assert not wrong, "\n".join(wrong)
