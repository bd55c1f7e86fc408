"""The console of answers: at a terminal, sentences wrap between words; a pipe or a file takes whole lines."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Iterable
from typing import Any

from rich.console import Console

PIPE_WIDTH = 120
"""Columns of tables where there is no terminal."""


class AnswerConsole(Console):
    """A console whose sentences (`soft_wrap`) wrap between words at a terminal, with their own indent kept.

    Warnings go to standard error, each once, where the answer shows what they warn of.
    """

    def __init__(self, warn: Callable[[str], None] = lambda text: None, **options: Any) -> None:
        super().__init__(**options)
        self._warn = warn
        self._warned: set[str] = set()

    def show_warnings(self, warnings: Iterable[str]) -> None:
        """Write warnings that were not written yet."""
        for text in warnings:
            if text not in self._warned:
                self._warned.add(text)
                self.file.flush()
                self._warn(text)

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as rich does; a sentence as lines that fit the terminal."""
        if options.get("soft_wrap") and self.is_terminal:
            objects = tuple(wrapped(item, self.width) if isinstance(item, str) else item for item in objects)
        super().print(*objects, **options)


def answer_console(warn: Callable[[str], None] = lambda text: None) -> AnswerConsole:
    """Return the console of an answer on standard output; `warn` writes a warning to standard error."""
    width = None if sys.stdout.isatty() else PIPE_WIDTH
    return AnswerConsole(warn, highlight=False, emoji=False, markup=False, width=width)


def wrapped(text: str, width: int) -> str:
    """Wrap each line of a text between words; what is indented stays so, and a path is left whole.

    Examples
    --------
    >>> print(wrapped("  a line that is too long", 14))
      a line that
      is too long
    >>> wrapped("/a/path/longer/than/that", 10)
    '/a/path/longer/than/that'
    """
    lines = []
    for line in text.split("\n"):
        indent = " " * (len(line) - len(line.lstrip(" ")))
        filled = textwrap.fill(
            line.strip(" "), width, initial_indent=indent, subsequent_indent=indent, break_long_words=False,
            break_on_hyphens=False,
        )  # fmt: skip
        lines.append(filled if line.strip() else line)
    return "\n".join(lines)
