"""Find TOML in texts that are printed: keys with values, in sentences and in lines of their own."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator, Sequence

HOLE = "\x00"
"""Stands for what an f-string fills in."""
# The keys of our files begin with a small letter; "p = 0.03" and the like are results, no keys.
_KEY = re.compile(r"""(?<![\w.="'`\-])(?P<key>[a-z][\w.-]+) = (?=\S)""")
_SCALAR = re.compile(r"(?:true|false|[-+]?\d[\d_.eE+-]*)(?![\w%])")
# A key that an f-string fills in is quoted by nobody: `toml_text.pair` writes keys.
_FILLED_KEY = re.compile(rf"[\w.-]*{HOLE}[\w.-]* = ")


def pairs_in(text: str) -> Iterator[str]:
    """Yield every `key = value` of a text, the value up to its end; without an end, all that follows."""
    place = 0
    while (match := _KEY.search(text, place)) is not None:
        end = _end_of_value(text, match.end())
        if end is not None:
            yield text[match.start() : end]
        elif text[match.end()] in "\"'[{":
            yield text[match.start() :]
        place = end or match.end()


def _end_of_value(text: str, place: int) -> int | None:
    mark = text[place]
    if mark in "\"'":
        return _end_of_string(text, place)
    if mark in "[{":
        return _end_of_brackets(text, place)
    match = _SCALAR.match(text, place)
    return match.end() if match is not None else None


def _end_of_string(text: str, place: int) -> int | None:
    mark, at = text[place], place + 1
    while at < len(text) and text[at] != mark:
        at += 2 if text[at] == "\\" and mark == '"' else 1
    return at + 1 if at < len(text) else None


def _end_of_brackets(text: str, place: int) -> int | None:
    depth, at = 0, place
    while at < len(text):
        if text[at] in "\"'":
            end = _end_of_string(text, at)
            if end is None:
                return None
            at = end
            continue
        depth += (text[at] in "[{") - (text[at] in "]}")
        at += 1
        if depth == 0:
            return at
    return None


def printed_texts(nodes: Sequence[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield the texts of a module that may be printed, with their lines: all but the documentation of the code.

    Parameters
    ----------
    nodes : all of the module.
    """
    documentation = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    parts = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in nodes:
        if id(node) in documentation or id(node) in parts:
            continue
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value
        elif isinstance(node, ast.JoinedStr):
            pieces = (part.value if isinstance(part, ast.Constant) else HOLE for part in node.values)
            yield node.lineno, "".join(str(piece) for piece in pieces)


def wrong_toml(text: str) -> Iterator[str]:
    """Yield the pieces of a text that nobody can paste."""
    for piece in pairs_in(text):
        if HOLE not in piece:
            try:
                tomllib.loads(piece)
            except tomllib.TOMLDecodeError:
                yield piece
        elif re.search(rf"[\"'][^\"']*{HOLE}[^\"']*[\"']", piece) or _FILLED_KEY.search(piece) or "…" in piece:
            yield piece.replace(HOLE, "{}")
