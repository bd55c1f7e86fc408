"""The code blocks of the hand-written pages."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

DOCS = Path(__file__).parent
GENERATED = DOCS / "reference" / "generated"


@dataclass(frozen=True)
class Block:
    """One fenced block."""

    page: str
    line: int
    language: str
    tag: str
    """run, output, file, check or show."""
    reason: str
    """What stands after the tag: why a block is only shown, the name of a file."""
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
        # a directive, such as {toctree} or {picture}, is no code
        if token.type == "fence" and token.map is not None and not token.info.startswith("{"):
            language, tag, reason = ([*token.info.split(None, 2), "", "", ""])[:3]
            found.append(Block(name, token.map[0] + 1, language, tag, reason, token.content))
    return found


PICTURE = re.compile(r"^```\{picture\} (\S+)(?: page (\d+))?\n", re.MULTILINE)


def pictures_of(name: str) -> list[tuple[str, int]]:
    """Return (file, page) of the pictures that a page's commands make; page 0 where the file is a picture itself."""
    return [(file, int(page or 0)) for file, page in PICTURE.findall(page_text(name))]
