"""An effect's picture in letters, for a terminal and for a README: its curve over a dotted one without it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.report.content import EffectPicture

WIDTH, HEIGHT = 57, 13
WITHOUT, THERE, BACK = "·", "o", "x"


def sketch(picture: EffectPicture) -> list[str]:
    """Return the picture as lines of text: ``·`` without the effect, ``o`` with it, ``x`` where the load goes back.

    Parameters
    ----------
    picture : as `stiffcal.report.effect_pictures.drawing.effect_picture` computes it.

    Examples
    --------
    >>> import numpy as np
    >>> ramp = np.linspace(-1.0, 1.0, 5)
    >>> still = np.zeros(5, dtype=bool)
    >>> lines = sketch(EffectPicture("none", "force [N]", "deflection [mm]", ramp, ramp, 2.0 * ramp, still, ""))
    >>> lines[0], lines[-1].strip()
    ('deflection [mm], −2.00 to 2.00', 'force [N], −1.00 to 1.00')
    """
    both = np.concatenate([picture.without, picture.with_effect])
    frame = (_range(picture.x), _range(both))
    page = np.full((HEIGHT, WIDTH), " ")
    column, row = _cells(np.zeros(1), np.zeros(1), frame)
    page[:, column[0]], page[row[0], :] = "│", "─"
    page[row[0], column[0]] = "┼"
    steps = len(picture.x) - 1
    _draw(page, picture.x, picture.without, frame, [WITHOUT] * steps)
    marks = [BACK if back else THERE for back in picture.unloading[1:]]
    _draw(page, picture.x, picture.with_effect, frame, marks)
    legend = f"{WITHOUT} without   {THERE} with it" + (f"   {BACK} {picture.back}" if picture.unloading.any() else "")
    return [
        f"{picture.y_label}, {_span(both)}",
        *("  " + "".join(line).rstrip() for line in page),
        f"  {legend}",
        f"  {picture.x_label}, {_span(picture.x)}",
    ]


def _range(values: Floats) -> tuple[float, float]:
    """Return the least and the largest value, zero among them."""
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 0.0)
    return (low, high) if high > low else (low - 1.0, high + 1.0)


def _span(values: Floats) -> str:
    low, high = (f"{value:.3g}" if abs(value) >= 100.0 else f"{value:.2f}" for value in _range(values))
    return f"{low} to {high}".replace("-", "−")


def _cells(x: Floats, y: Floats, frame: tuple[tuple[float, float], ...]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return columns from the left and rows from the top."""
    (left, right), (low, high) = frame
    column = np.rint((WIDTH - 1) * (x - left) / (right - left)).astype(np.int64)
    return column, np.rint((HEIGHT - 1) * (high - y) / (high - low)).astype(np.int64)


def _draw(
    page: NDArray[np.str_], x: Floats, y: Floats, frame: tuple[tuple[float, float], ...], marks: list[str]
) -> None:
    """Draw lines from point to point, each with its mark; what is drawn later lies on top."""
    share = np.linspace(0.0, 1.0, 2 * WIDTH)
    for k, mark in enumerate(marks):
        column, row = _cells(x[k] + share * (x[k + 1] - x[k]), y[k] + share * (y[k + 1] - y[k]), frame)
        page[row, column] = mark
