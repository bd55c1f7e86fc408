"""Points in characters: a picture of a few lines for a terminal, each of its cells two by four dots of braille."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.wording import significant

if TYPE_CHECKING:
    from stiffcal.arrays import Floats

HEIGHT = 6
"""Lines of the picture itself: with title and axis nine, so that an answer stays on a screen."""
WIDTH = 64
"""Columns of the picture itself: with the numbers left of it within 80."""
_ACROSS, _DOWN = 2, 4
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""What each dot adds to the number of a character, from the top and from the left."""
_BLANK = 0x2800


def plot_points(x: Floats, y: Floats, labels: tuple[str, str], width: int = 80) -> list[str]:
    """Return points as lines: a title with both axes, the picture with a line at zero, the numbers below.

    Parameters
    ----------
    x, y : (n,) points that are not finite are left out.
    labels : of x and y, with their units. width : columns that there are.

    Raises
    ------
    ValueError : no point is finite.
    """
    import numpy as np

    finite = np.isfinite(x) & np.isfinite(y)
    x, y = x[finite], y[finite]
    (left, right), (low, high) = _range(x), _range(np.append(y, 0.0))
    marks = {0: _number(high), HEIGHT - 1: _number(low)}
    zero = round((HEIGHT - 1) * high / (high - low))
    marks.setdefault(zero, "0")
    margin = max(map(len, marks.values()))
    columns = min(WIDTH, width - margin - 3)
    across = np.rint((columns * _ACROSS - 1) * (x - left) / (right - left)).astype(np.int64)
    down = np.rint((HEIGHT * _DOWN - 1) * (high - y) / (high - low)).astype(np.int64)
    cells = np.zeros((HEIGHT, columns), dtype=np.int64)
    np.bitwise_or.at(cells, (down // _DOWN, across // _ACROSS), np.array(_DOTS)[down % _DOWN, across % _ACROSS])
    lines = [f"{labels[1]} over {labels[0]}"]
    for row, dots in enumerate(cells.tolist()):
        empty = "·" if row == zero else " "
        drawn = "".join(chr(_BLANK + dot) if dot else empty for dot in dots).rstrip()
        lines.append(f"{marks.get(row, ''):>{margin}} {'┤' if row in marks else '│'}{drawn}")
    lines.append(f"{'':>{margin}} └{'─' * columns}")
    lines.append(f"{'':>{margin}}  {_axis(left, right, columns)}")
    return lines


def _range(values: Floats) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return (low, high) if high > low else (low - 1.0, high + 1.0)


def _axis(left: float, right: float, columns: int) -> str:
    """Return the numbers below the picture: both ends, and zero where it lies between them."""
    first, last = _number(left), _number(right)
    text = first.ljust(columns - len(last)) + last
    if left < 0.0 < right:
        at = round((columns - 1) * -left / (right - left))
        if len(first) < at - 1 and at + 1 < columns - len(last) - 1:
            text = f"{text[:at]}0{text[at + 1 :]}"
    return text


def _number(value: float) -> str:
    return significant(value).replace("-", "−")
