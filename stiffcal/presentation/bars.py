"""Bars in characters, linear from zero, and the same amounts as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.presentation.values import Column, Table
from stiffcal.wording import significant

if TYPE_CHECKING:
    from stiffcal.presentation.values import Bars

MARK, FLOOR, EIGHTHS = "│", "░", " ▏▎▍▌▋▊▉"
IN_TABLE = 24
"""Characters of the longest bar in a table."""


def bar(length: float, mark: float | None, room: int, fill: str = "") -> str:
    """Return a bar of so many characters, with a mark at another.

    Examples
    --------
    >>> bar(2.5, None, 10)
    '██▌'
    """
    eighths = round(8.0 * length)
    text = (fill or "█") * (eighths // 8) + (EIGHTHS[eighths % 8].strip() if not fill else "")
    if mark is None or mark > room:
        return text
    cell = min(int(mark), room - 1)
    return text[:cell].ljust(cell) + MARK + text[cell + 1 :]


def drawn_bars(bars: Bars, room: int) -> list[str]:
    """Return a bar for each amount, all on one scale; of what is beyond it, how many times as large it is."""
    sizes = [one.size for one in bars.bars]
    scale = max((one.size or 0.0 for one in bars.bars if one.is_on_scale), default=0.0)
    if not scale > 0.0:
        return [""] * len(sizes)
    at = None if sizes[-1] is None else room * sizes[-1] / scale
    texts = []
    for number, size in enumerate(sizes, start=1):
        if size is None:
            texts.append("")
        elif size > scale * (1.0 + 0.5 / room):
            texts.append(_beyond(size / scale, room))
        else:
            texts.append(bar(room * size / scale, at, room, FLOOR if number == len(sizes) else ""))
    return texts


def _beyond(times: float, room: int) -> str:
    """Return how many times as long as the longest bar one would be, in the most words that have room."""
    short = f"{significant(times)} ×"
    longer = f"{short} the longest bar"
    return next((text for text in (f"off the scale: {longer}", longer) if len(text) <= room), short)


def table_of(bars: Bars) -> Table:
    """Return the amounts as a table, for media that draw no bars of their own."""
    columns = (Column(bars.title, numbers=False), Column(bars.amount), Column("", numbers=False))
    rows = zip(bars.bars, drawn_bars(bars, IN_TABLE), strict=True)
    return Table(columns, tuple(((one.name,), (one.text,), (text,)) for one, text in rows))
