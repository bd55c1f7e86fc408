"""The pages of the documentation as tests use them."""

from __future__ import annotations

import re

from docs.page_blocks import DOCS, page_text

ROOT = DOCS.parent


def indented_blocks(name: str) -> list[int]:
    """Return the lines of blocks that are code by their indent alone, and therefore have no tag."""
    from markdown_it import MarkdownIt

    tokens = MarkdownIt().parse(page_text(name))
    return [token.map[0] + 1 for token in tokens if token.type == "code_block" and token.map is not None]


def plugin_of_the_documentation() -> str:
    """Return the effect that the page on own effects shows."""
    blocks = re.findall(r"```python[^\n]*\n(.*?)```", page_text("how-to/own-effect.md"), flags=re.DOTALL)
    (text,) = (block for block in blocks if "class CrossStiffness" in block)
    return str(text)
