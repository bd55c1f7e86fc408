"""Sentences on standard error: wrapped between words at a terminal, one line each elsewhere."""

from __future__ import annotations

import sys


def for_terminal(text: str) -> str:
    """Return a sentence for standard error: wrapped between words at a terminal, one line elsewhere."""
    if not sys.stderr.isatty():
        return text
    from shutil import get_terminal_size

    from stiffcal.cli.console import wrapped

    return wrapped(text, get_terminal_size().columns)
