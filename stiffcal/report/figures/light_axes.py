"""Axes of a panel drawn with a single tick, which is moved from one tick location to the next.

Why: a tick of matplotlib is five artists, and a report has two thousand ticks, which took nearly half the time of all
pictures. Here grid and tick marks of an axis are one line each, and one text draws all labels.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axis import Axis, Tick
    from matplotlib.backend_bases import RendererBase
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.transforms import Bbox


def lighten_axes(figure: Figure) -> None:
    """Have all axes of a figure drawn by `_draw_axis`; nothing changes in what is drawn.

    Parameters
    ----------
    figure : whose ticks all look alike within an axis: a tick that was given a look of its own would lose it. Figures
        with a layout of matplotlib, which measures each tick, stay as they are.
    """
    if figure.get_layout_engine() is not None:
        return
    for panel in figure.axes:
        for axis in (panel.xaxis, panel.yaxis):
            vars(axis)["draw"] = partial(_draw_axis, axis)


def _draw_axis(axis: Axis, renderer: RendererBase) -> None:
    """Draw grid, marks, labels and title of an axis, as `matplotlib.axis.Axis.draw` does."""
    if not axis.get_visible():
        return
    renderer.open_group("axis", gid=axis.get_gid())
    boxes = [
        *_draw_ticks(axis, axis.get_majorticklocs(), axis.get_major_formatter(), axis.get_major_ticks, renderer),
        *_draw_ticks(axis, axis.get_minorticklocs(), axis.get_minor_formatter(), axis.get_minor_ticks, renderer),
    ]
    _place_title(axis, boxes)
    axis.label.draw(renderer)
    axis.offsetText.set_text(axis.get_major_formatter().get_offset())
    if axis.offsetText.get_text():
        axis.offsetText.draw(renderer)
    renderer.close_group("axis")
    axis.stale = False


def _draw_ticks(
    axis: Axis, places: Any, formatter: Any, ticks: Callable[[int], list[Tick]], renderer: RendererBase
) -> list[Bbox]:
    """Draw the major or the minor ticks, and return the extents of the longest labels in pixels.

    The title of the axis is placed by them; to measure all labels takes as long as to draw them.
    """
    at = np.asarray(places, dtype=np.float64)
    if not at.size:
        return []
    labels = formatter.format_ticks(at)
    shown = _inside(axis, at)
    at, labels = at[shown], [label for label, is_shown in zip(labels, shown, strict=True) if is_shown]
    if not at.size:
        return []
    tick = ticks(1)[0]
    across = _is_vertical(axis)
    _draw_line(tick.gridline, *_grid(at, across), renderer)
    for line, side in ((tick.tick1line, 0.0), (tick.tick2line, 1.0)):
        _draw_line(line, *_exchanged(at, np.full_like(at, side), across), renderer)
    longest = max(len(label) for label in labels)
    boxes = []
    for text in (tick.label1, tick.label2):
        if not text.get_visible():
            continue
        for place, label in zip(at.tolist(), labels, strict=True):
            if label:
                tick.update_position(place)
                text.set_text(label)
                text.draw(renderer)
                if len(label) == longest:
                    boxes.append(text.get_window_extent(renderer))
    return boxes


def _inside(axis: Axis, at: Floats) -> Any:
    """Return (n,) whether each tick lies within the panel."""
    transform = axis.get_transform()
    low, high = sorted(transform.transform(np.asarray(axis.get_view_interval(), dtype=np.float64)).tolist())
    place = transform.transform(at)
    slack = 1e-10 * (high - low)
    return (place >= low - slack) & (place <= high + slack)


def _grid(at: Floats, across: bool) -> tuple[Floats, Floats]:
    """Return one line through all ticks, across the panel at each, interrupted between them."""
    along = np.repeat(at, 3)
    along[2::3] = np.nan
    return _exchanged(along, np.tile([0.0, 1.0, np.nan], at.size), across)


def _exchanged(first: Floats, second: Floats, exchange: bool) -> tuple[Floats, Floats]:
    return (second, first) if exchange else (first, second)


def _draw_line(line: Line2D, x: Floats, y: Floats, renderer: RendererBase) -> None:
    if line.get_visible():
        line.set_data(x, y)
        line.draw(renderer)


def _place_title(axis: Axis, boxes: list[Bbox]) -> None:
    """Put the title of an axis below or to the left of its labels."""
    from matplotlib.transforms import Bbox

    if not axis.label.get_text():
        return
    is_vertical = _is_vertical(axis)
    points = axis.labelpad
    if not boxes:  # then the title keeps clear of the marks
        points += axis.get_major_ticks(1)[0].get_tick_padding()
    gap = points * axis.get_figure(root=True).dpi / 72.0  # type: ignore[union-attr]
    room = Bbox.union(boxes or [axis.axes.bbox])
    x, y = axis.label.get_position()
    axis.label.set_position((room.x0 - gap, y) if is_vertical else (x, room.y0 - gap))


def _is_vertical(axis: Axis) -> bool:
    return axis is axis.axes.yaxis
