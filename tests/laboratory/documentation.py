"""The pages of the documentation and their code blocks, for the tests that parse and execute them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GENERATED = DOCS / "reference" / "generated"


@dataclass(frozen=True)
class Block:
    """One fenced block."""

    page: str
    line: int
    language: str
    tag: str
    """run, output, check or show."""
    reason: str
    """What stands after the tag."""
    text: str


def hand_written_pages() -> list[str]:
    """Return the names of the pages that people write, relative to docs/."""
    files = (file for file in DOCS.rglob("*.md") if GENERATED not in file.parents)
    return sorted(file.relative_to(DOCS).as_posix() for file in files)


def page_text(name: str) -> str:
    """Return a page's Markdown; `name` relative to docs/."""
    return (DOCS / name).read_text(encoding="utf-8")


def blocks_of(name: str) -> list[Block]:
    """Return the fenced blocks of one page."""
    found = []
    for token in MarkdownIt().parse(page_text(name)):
        # a directive of MyST, such as {toctree}, is no code
        if token.type == "fence" and token.map is not None and not token.info.startswith("{"):
            language, tag, reason = ([*token.info.split(None, 2), "", "", ""])[:3]
            found.append(Block(name, token.map[0] + 1, language, tag, reason, token.content))
    return found


def indented_blocks(name: str) -> list[int]:
    """Return the lines of blocks that are code by their indent alone, and therefore have no tag."""
    tokens = MarkdownIt().parse(page_text(name))
    return [token.map[0] + 1 for token in tokens if token.type == "code_block" and token.map is not None]


def plugin_of_the_documentation() -> str:
    """Return the effect that the page on own effects shows."""
    blocks = re.findall(r"```python[^\n]*\n(.*?)```", page_text("how-to/own-effect.md"), flags=re.DOTALL)
    (text,) = (block for block in blocks if "class CrossStiffness" in block)
    return str(text)
