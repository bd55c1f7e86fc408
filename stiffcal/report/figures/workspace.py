"""Quantities over the workspace: coloured where the robot reaches, with reach and joint limits (003, Fig. 4, 5)."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.report.content import Floats, WorkspacePicture
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Readable in grey and to the colour-blind: dark to light in one even run.
_MAP = "viridis"
_LIMIT_DEG = 5.0
_MOST_ACROSS = 3
_MOST_LETTERS = 30  # of a label below a panel


@canvas.styled
def draw_workspace(picture: WorkspacePicture) -> Figure:
    """Draw each quantity over a plane; of several planes one row each, every quantity on one scale.

    Returns
    -------
    Figure; places in m.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    count = len(picture.quantities)
    panels = [(level, number) for level in range(len(picture.levels)) for number in range(count)]
    columns = min(len(panels) if count == 1 else count, _MOST_ACROSS)
    rows = -(-len(panels) // columns)
    ratio = float(np.ptp(picture.up) / np.ptp(picture.across))
    width = canvas.PAGE_WIDTH_MM / columns
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, rows * (0.84 * width * min(max(ratio, 0.5), 1.6) + 24) + 15)
    drawn = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (level, number) in zip(drawn, panels, strict=False):
        _draw_panel(figure, axes, picture, level, number)
    for axes in drawn[len(panels) :]:
        axes.set_axis_off()
    figure.suptitle(picture.title, fontsize=7.0, x=0.01, ha="left")
    handles = [
        Line2D(
            [], [], color=canvas.INK, linewidth=1.2, marker="o", markersize=2.4, markerfacecolor="white", label="arm"
        ),
        Patch(facecolor=canvas.PALE, label="out of reach"),
        Patch(facecolor="#f4f4f4", edgecolor=canvas.QUIET, hatch="xxxx", label="only beyond joint limits"),
    ]
    if (picture.margin < _LIMIT_DEG).any():
        label = f"{_LIMIT_DEG:g}° from a joint limit"
        handles.append(Line2D([], [], color=canvas.ACCENT, linestyle="--", linewidth=0.9, label=label))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _draw_panel(figure: Figure, axes: Axes, picture: WorkspacePicture, level: int, number: int) -> None:
    from matplotlib.ticker import MaxNLocator

    name, unit, values = picture.quantities[number]
    status = picture.status[level]
    axes.grid(visible=False)
    axes.set_facecolor(canvas.PALE)
    limits = np.where(status == 1, 1.0, np.nan)
    if np.isfinite(limits).any():
        axes.contourf(
            picture.across, picture.up, np.where(status == 1, 1.0, 0.0), levels=[0.5, 1.5], colors=["#f4f4f4"],
            hatches=["xxxx"], zorder=1,
        )  # fmt: skip
    low, high = _scale(values)
    mesh = axes.pcolormesh(
        picture.across, picture.up, np.ma.masked_invalid(values[level]), cmap=_MAP, shading="nearest",
        vmin=low, vmax=high, rasterized=True, zorder=2,
    )  # fmt: skip
    margin = picture.margin[level]
    if (margin < _LIMIT_DEG).any() and (margin > _LIMIT_DEG).any():
        axes.contour(
            picture.across, picture.up, np.ma.masked_invalid(margin), levels=[_LIMIT_DEG], colors=[canvas.ACCENT],
            linewidths=0.9, linestyles="--", zorder=3,
        )  # fmt: skip
    axes.plot(
        picture.stick[:, 0], picture.stick[:, 1], color=canvas.INK, linewidth=1.2, marker="o", markersize=2.4,
        markerfacecolor="white", zorder=4,
    )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_xlim(picture.across[0], picture.across[-1])
    axes.set_ylim(picture.up[0], picture.up[-1])
    across, up, through = picture.axes
    axes.set_xlabel(f"{across} [m]")
    axes.set_ylabel(f"{up} [m]")
    axes.set_title(f"{through} = {round(picture.levels[level], 3):g} m")
    bar = figure.colorbar(mesh, ax=axes, location="bottom", shrink=0.9, aspect=28, extend=_beyond(values, low, high))
    bar.set_label(fill(f"{name} [{unit}]", _MOST_LETTERS))
    bar.locator = MaxNLocator(5)
    bar.update_ticks()
    bar.outline.set_linewidth(0.4)


def _scale(values: Floats) -> tuple[float, float]:
    """Return the ends of the colours: all but the outermost hundredth, which singular poses would stretch it by."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 1.0
    low, high = (float(np.quantile(known, share)) for share in (0.01, 0.99))
    if low > 0.0 and low < 0.3 * high:
        low = 0.0
    return low, high if high > low else low + 1.0


def _beyond(values: Floats, low: float, high: float) -> str:
    known = values[np.isfinite(values)]
    below, above = bool((known < low).any()), bool((known > high).any())
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")
