"""Cells, code and tables of Markdown."""

from __future__ import annotations

from collections.abc import Sequence


def cell(text: object) -> str:
    """Return a text as it stands in a cell of a Markdown table."""
    return " ".join(str(text).split()).replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def code(text: object) -> str:
    """Return a text as code in a cell of a Markdown table."""
    return "`" + str(text).replace("|", "\\|") + "`"


def table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines) + "\n"
