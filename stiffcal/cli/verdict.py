"""The verdict of an answer: a word and a colour, first of all that is printed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from rich.console import Console

Level: TypeAlias = Literal["pass", "warn", "fail"]
_STYLES: dict[Level, str] = {"pass": "bold green", "warn": "bold yellow", "fail": "bold red"}


def show_verdict(console: Console, level: Level, text: str) -> None:
    """Print a verdict: its word in its colour at a terminal, the word alone in a pipe or with NO_COLOR.

    Parameters
    ----------
    console : where to. level : how it stands. text : the verdict in a sentence.
    """
    from rich.text import Text

    line = Text.assemble((level.upper(), _STYLES[level]), "  ", text)
    console.print(line, soft_wrap=not console.is_terminal)


def diagnosis_level(adequate: bool | None, missing: bool) -> Level:
    """Return how a diagnosis stands: pass where nothing is missing, warn where something is, or cannot be judged."""
    return "pass" if adequate and not missing else "warn"
