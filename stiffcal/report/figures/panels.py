"""Panels of marks, lines and bands, whatever they show: the pictures of kinds of experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.presentation.pictures import Band, Colour, Line, Marks, Panel, Picture, Series, Span
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LETTERS_ACROSS = 90
"""Letters of names below an axis over the width of a page."""


@canvas.styled
def draw_panels(picture: Picture) -> Figure:
    """Draw all panels, row by row; labels that stand in no panel's own legend stand in one above all."""
    rows = -(-len(picture.panels) // picture.columns)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, picture.height)
    ratios = {"width_ratios": list(picture.widths)} if picture.widths else None
    axes = figure.subplots(rows, picture.columns, squeeze=False, gridspec_kw=ratios).ravel().tolist()
    for spare in axes[len(picture.panels) :]:
        spare.set_axis_off()
    handles: dict[str, Any] = {}
    for panel, drawn in zip(picture.panels, axes, strict=False):
        _draw(drawn, panel)
        if not panel.has_own_legend:
            for handle, label in zip(*drawn.get_legend_handles_labels(), strict=True):
                handles.setdefault(label, handle)
    canvas.share_legend(figure, list(handles.values()))
    return figure


def _draw(axes: Axes, panel: Panel) -> None:
    if panel.empty:
        axes.set_axis_off()
        axes.text(0.5, 0.5, panel.empty, ha="center", va="center", color=canvas.QUIET)
        return
    for series in panel.series:
        _draw_series(axes, series)
    if panel.has_zero_lines:
        canvas.zero_lines(axes)
    if panel.title:
        axes.set_title(panel.title)
    if panel.x_names:
        # as many letters stand next to each other in the width of a page
        upright = sum(map(len, panel.x_names)) > LETTERS_ACROSS
        axes.set_xticks(range(len(panel.x_names)), panel.x_names, rotation=90 if upright else 0)
    if panel.y_names:
        axes.set_yticks(range(len(panel.y_names)), panel.y_names)
    if panel.x_limits is not None:
        axes.set_xlim(*panel.x_limits)
    if panel.y_limits is not None:
        axes.set_ylim(*panel.y_limits)
    if panel.head_room is not None:
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, 0.0), high + panel.head_room * (high - min(low, 0.0)))
    if panel.x_ticks is not None:
        axes.locator_params(axis="x", nbins=panel.x_ticks)
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    if panel.has_own_legend and axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", handletextpad=0.2, borderpad=0.2)


def _draw_series(axes: Axes, series: Series) -> None:
    label = canvas.in_legend(series.label) if series.label else None
    match series:
        case Span():
            axes.axvspan(series.low, series.high, color=canvas.PALE, linewidth=0, label=label, zorder=series.layer)
        case Band():
            axes.fill_between(
                series.x, series.low, series.high, color=canvas.PALE, linewidth=0, label=label, zorder=series.layer
            )
        case Line():
            axes.plot(
                series.x, series.y, color=_colour(series.colour), linestyle="--" if series.is_dashed else "-",
                linewidth=series.width, label=label, zorder=series.layer,
            )  # fmt: skip
        case Marks():
            _draw_marks(axes, series, label)


def _draw_marks(axes: Axes, marks: Marks, label: str | None) -> None:
    colour = _colour(marks.colour)
    style: dict[str, Any] = {
        "linestyle": "none",
        "marker": canvas.MARKERS[int(marks.marker) % len(canvas.MARKERS)] if marks.marker.isdecimal() else marks.marker,
        "markersize": marks.size,
        "markeredgewidth": marks.edge,
        "markerfacecolor": "none" if marks.is_hollow else colour,
        "color": colour,
        "alpha": marks.opacity,
        "label": label,
        "zorder": marks.layer,
    }
    if marks.spread is None:
        axes.plot(marks.x, marks.y, **style)
    else:
        axes.errorbar(marks.x, marks.y, yerr=marks.spread, capsize=2.0, elinewidth=0.7, **style)
    if marks.note and np.size(marks.x):
        axes.annotate(
            marks.note, (float(marks.x[-1]), float(marks.y[-1])), xytext=(0, 7), textcoords="offset points",
            ha="center", va="bottom", rotation=90, fontsize=5.5, color=canvas.INK, zorder=5,
            # a line may pass behind it
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
        )  # fmt: skip


def _colour(colour: Colour) -> str:
    if isinstance(colour, int):
        return canvas.COLOURS[colour % len(canvas.COLOURS)]
    return {"model": canvas.MODEL, "quiet": canvas.QUIET}[colour]
