"""One line to the user from below the command line: to standard error, or to whatever the process has set."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from stiffcal.masking import mask

_outlets: list[Callable[[str], None]] = []
_given: set[str] = set()


def notices_to(outlet: Callable[[str], None]) -> None:
    """Have notices go to a function instead of standard error: in a process whose standard error is not shown."""
    _outlets[:] = [outlet]


@contextmanager
def notices_diverted(outlet: Callable[[str], None]) -> Iterator[None]:
    """Have notices go to a function for a while."""
    before = list(_outlets)
    _outlets[:] = [outlet]
    try:
        yield
    finally:
        _outlets[:] = before


def notice(line: str, subject: str = "") -> None:
    """Give the user one line, once in this process.

    Parameters
    ----------
    line : the text.
    subject : what it is about; of several lines about one subject the first is enough.
    """
    if (subject or line) in _given:
        return
    _given.add(subject or line)
    if _outlets:
        _outlets[0](mask(line))
        return
    with suppress(OSError, ValueError, AttributeError):  # standard error may be closed, or absent
        sys.stderr.write(mask(line) + "\n")
        sys.stderr.flush()
