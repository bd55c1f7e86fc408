"""Panels placed by the room that their texts need, without drawing them first.

Why not matplotlib's constrained layout: it draws every picture twice and measures each text on the way, which took half
of a report's time. The sizes of tick labels, axis labels and titles are known from the font's table of widths.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec
    from matplotlib.text import Text

MM_PER_POINT = 25.4 / 72.0
# Height of a line of text over its font size, and width of a text as drawn over that of its letters: each letter begins
# at a whole pixel.
LINE, WIDENING = 1.25, 1.08
# Space at the edges of the picture and between texts, mm.
EDGE, GAP = 0.8, 1.2
# Space between neighbouring panels that have no text between them, mm.
LEAST_GUTTER = 2.5


@dataclass(frozen=True)
class _Room:
    """What the texts around a panel need, mm."""

    left: float
    right: float
    bottom: float
    top: float


def place_panels(figure: Figure) -> None:
    """Set the margins of a figure's grid of panels; figures without one grid keep their places.

    Parameters
    ----------
    figure : whose panels come from `Figure.subplots`.
    """
    panels = [axes for axes in figure.axes if axes.get_subplotspec() is not None]
    grids: dict[int, tuple[GridSpec, list[Axes]]] = {}
    for axes in panels:
        spec = axes.get_subplotspec()
        assert spec is not None
        grid = spec.get_gridspec()
        grids.setdefault(id(grid), (grid, []))[1].append(axes)  # type: ignore[arg-type]
    if len(grids) != 1:
        return
    ((grid, members),) = grids.values()
    strip = _legend_height(figure)
    _place(figure, grid, members, strip)
    if _break_long_labels(figure, members):
        _place(figure, grid, members, strip)


def _place(figure: Figure, grid: GridSpec, panels: list[Axes], strip: float) -> None:
    width, height = (float(size) * 25.4 for size in figure.get_size_inches())
    left: dict[int, float] = defaultdict(float)
    right: dict[int, float] = defaultdict(float)
    bottom: dict[int, float] = defaultdict(float)
    top: dict[int, float] = defaultdict(float)
    for axes in panels:
        if not axes.get_visible():
            continue
        spec, room = axes.get_subplotspec(), _room_around(axes)
        assert spec is not None
        columns, rows = spec.colspan, spec.rowspan
        left[columns.start] = max(left[columns.start], room.left)
        right[columns.stop - 1] = max(right[columns.stop - 1], room.right)
        top[rows.start] = max(top[rows.start], room.top)
        bottom[rows.stop - 1] = max(bottom[rows.stop - 1], room.bottom)
    n_rows, n_columns = grid.nrows, grid.ncols
    across = [max(LEAST_GUTTER, right[c - 1] + left[c] + GAP) for c in range(1, n_columns)]
    down = [max(LEAST_GUTTER, bottom[r - 1] + top[r] + GAP) for r in range(1, n_rows)]
    x_low, x_high = EDGE + left[0], width - EDGE - right[n_columns - 1]
    y_low, y_high = EDGE + bottom[n_rows - 1], height - EDGE - top[0] - strip
    x_gap, y_gap = max(across, default=0.0), max(down, default=0.0)
    panel_width = max((x_high - x_low - x_gap * (n_columns - 1)) / n_columns, 1.0)
    panel_height = max((y_high - y_low - y_gap * (n_rows - 1)) / n_rows, 1.0)
    y_high = max(y_high, y_low + 1.0)
    figure.subplots_adjust(
        left=x_low / width,
        right=max(x_high, x_low + 1.0) / width,
        bottom=y_low / height,
        top=y_high / height,
        wspace=x_gap / panel_width,
        hspace=y_gap / panel_height,
    )
    if n_rows > 2 and max(down) - min(down) > GAP:
        _space_rows(grid, panels, down, (y_low, y_high), height)


def _break_long_labels(figure: Figure, panels: list[Axes]) -> bool:
    """Write labels of axes that are longer than their panel in two lines; return whether there were any.

    A longer one runs into that of the next panel, or out of the picture.
    """
    width, height = (float(size) * 25.4 for size in figure.get_size_inches())
    broken = False
    for axes in panels:
        box = axes.get_position(original=True)
        for label, side in ((axes.xaxis.label, box.width * width), (axes.yaxis.label, box.height * height)):
            if _shows(label) and _extent(label)[0] > side + LEAST_GUTTER:
                text = in_two_lines(label.get_text(), float(label.get_fontsize()))
                broken = broken or text != label.get_text()
                label.set_text(text)
                label.set_multialignment("center")
    return broken


def in_two_lines(text: str, points: float) -> str:
    r"""Return a text broken where its two lines are most alike in length; as it is where it has no space or two lines.

    Examples
    --------
    >>> in_two_lines("rotation residual [mrad]", 7.0)
    'rotation\nresidual [mrad]'
    """
    words = text.split(" ")
    if len(words) < 2 or "\n" in text:
        return text
    pairs = [f"{' '.join(words[:k])}\n{' '.join(words[k:])}" for k in range(1, len(words))]
    return min(pairs, key=lambda pair: _text_size(pair, points)[0])


def _space_rows(
    grid: GridSpec, panels: list[Axes], gaps: list[float], ends: tuple[float, float], height: float
) -> None:
    """Place rows of panels with the gap that each needs, where the largest one between all would leave little of them.

    Parameters
    ----------
    grid, panels : whose columns are placed already. gaps : mm below each row but the last.
    ends : mm, lower and upper edge of the whole grid. height : mm, the picture's.
    """
    shares: list[float] = np.asarray(grid.get_height_ratios(), dtype=np.float64).tolist()
    free = max(ends[1] - ends[0] - sum(gaps), float(len(shares)))
    heights = [free * share / sum(shares) for share in shares]
    tops = [ends[1] - sum(heights[:row]) - sum(gaps[:row]) for row in range(len(shares))]
    for axes in panels:
        spec = axes.get_subplotspec()
        assert spec is not None
        first, last = spec.rowspan.start, spec.rowspan.stop - 1
        box = axes.get_position(original=True)
        low = tops[last] - heights[last]
        axes.set_position((box.x0, low / height, box.width, (tops[first] - low) / height))


def _room_around(axes: Axes) -> _Room:
    """Return what labels and titles of a panel need on each side, mm."""
    if not axes.axison:
        return _Room(0.0, 0.0, 0.0, _title_height(axes))
    x_width, x_height = _tick_labels(axes.xaxis, "x")
    y_width, _ = _tick_labels(axes.yaxis, "y")
    y_label, x_label = axes.yaxis.label, axes.xaxis.label
    left = y_width + _extent(y_label)[1] + (GAP if _shows(y_label) else 0.0)
    bottom = x_height + _extent(x_label)[1]
    # the last tick label is centred on the panel's edge
    return _Room(left, 0.5 * x_width, bottom, _title_height(axes))


def _tick_labels(axis: Axis, name: Literal["x", "y"]) -> tuple[float, float]:
    """Return width and height of the widest tick label with its tick, mm; zeros where none is shown."""
    shown = axis.get_tick_params(which="major")
    if not shown.get("labelbottom" if name == "x" else "labelleft", True) or not axis.get_visible():
        return 0.0, 0.0
    places = axis.get_majorticklocs()
    low, high = sorted(axis.get_view_interval())
    inside = [place for place in places if low - 1e-9 * (high - low) <= place <= high + 1e-9 * (high - low)]
    axis.get_major_formatter().axis = axis
    labels = axis.get_major_formatter().format_ticks(inside)
    if not any(labels):
        return 0.0, 0.0
    size, rotation = _label_size(axis, name), _label_rotation(axis)
    extents = [_turned(_text_size(label, size), rotation) for label in labels]
    tick = 3.5 * MM_PER_POINT * 2.0
    width, height = max(extent[0] for extent in extents), max(extent[1] for extent in extents)
    return (width + tick, height) if name == "y" else (width, height + tick)


def _label_size(axis: Axis, name: Literal["x", "y"]) -> float:
    from matplotlib import rcParams
    from matplotlib.font_manager import FontProperties

    usual = rcParams["xtick.labelsize"] if name == "x" else rcParams["ytick.labelsize"]
    given = axis.get_tick_params(which="major").get("labelsize", usual)
    return float(FontProperties(size=given).get_size_in_points())


def _label_rotation(axis: Axis) -> float:
    shown = axis.get_tick_params(which="major")
    # matplotlib calls it by the one name or the other, by its version
    return float(shown.get("rotation", shown.get("labelrotation", 0.0)))


def _title_height(axes: Axes) -> float:
    lines = max(len(axes.get_title(loc=place).splitlines()) for place in ("left", "center", "right"))
    size = axes.title.get_fontsize()
    return lines * LINE * float(size) * MM_PER_POINT + (2.0 * GAP if lines else 0.0)


def _shows(text: Text) -> bool:
    return bool(text.get_text()) and bool(text.get_visible())


def _extent(text: Text) -> tuple[float, float]:
    """Return length and thickness of an axis's label, mm; zeros where none is shown."""
    if not _shows(text):
        return 0.0, 0.0
    width, height = _text_size(text.get_text(), float(text.get_fontsize()))
    return width, height + GAP


def _legend_height(figure: Figure) -> float:
    """Return what the legends above all panels need, mm, and put them there."""
    height = 0.0
    for legend in figure.legends:
        columns = max(int(legend._ncols), 1)  # type: ignore[attr-defined]
        rows = -(-len(legend.get_texts()) // columns)
        size = legend.get_texts()[0].get_fontsize() if legend.get_texts() else 0.0
        legend.set_loc("upper center")
        legend.set_bbox_to_anchor((0.0, 0.0, 1.0, 1.0))
        height += rows * (LINE + 0.35) * float(size) * MM_PER_POINT + 2.0 * GAP
    return height


def _turned(size: tuple[float, float], degrees: float) -> tuple[float, float]:
    from math import cos, radians, sin

    width, height = size
    c, s = abs(cos(radians(degrees))), abs(sin(radians(degrees)))
    return width * c + height * s, width * s + height * c


@lru_cache(maxsize=4096)
def _text_size(text: str, points: float) -> tuple[float, float]:
    """Return width and height of a text in the report's font, mm."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    lines = text.split("\n")
    font = FontProperties(family=["DejaVu Sans"], size=points)
    widths: Iterable[float] = (text_to_path.get_text_width_height_descent(line, font, False)[0] for line in lines)
    return WIDENING * max(widths) * MM_PER_POINT, len(lines) * LINE * points * MM_PER_POINT
