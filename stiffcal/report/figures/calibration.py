"""Distances over the workspace before and after: with the robot file's robot, and with the identified one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quantity import LENGTH
from stiffcal.report import wording
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEIGHT_MM = 74.0
_AREA = 7.0
# Of all distances this share at each end has the colour of the end.
_LEAST = 0.01


@canvas.styled
def draw_calibration(place: Floats, before: Floats, after: Floats) -> Figure:
    """Draw where targets were measured, coloured by the distance between predicted and measured place.

    Parameters
    ----------
    place : (n, 3) m, base axes. before, after : (n,) m; both panels have the same logarithmic colours.
    """
    from matplotlib.colors import LogNorm

    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, _HEIGHT_MM, constrained=True)
    radius = np.hypot(place[:, 0], place[:, 1])
    titles = ("robot file, frames fitted", "identified, held-out regions")
    unit = canvas.unit_of(LENGTH, before)
    both = unit.factor * np.concatenate([before, after])
    low, high = (float(np.quantile(both, share)) for share in (_LEAST, 1.0 - _LEAST))
    colours = LogNorm(max(low, _LEAST * high), high)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, distance, title in zip(panels, (before, after), titles, strict=True):
        order = np.argsort(distance)  # the farthest on top
        drawn = axes.scatter(
            radius[order], place[order, 2], c=unit.factor * distance[order], s=_AREA, cmap="viridis", norm=colours,
            linewidths=0.0, rasterized=True,
        )  # fmt: skip
        axes.set_title(title)
        axes.set_xlabel("distance from the base's z axis [m]")
        axes.set_aspect("equal", adjustable="datalim")
    bar = figure.colorbar(drawn, ax=list(panels), location="bottom", shrink=0.6, aspect=40, extend="both")
    bar.ax.xaxis.set_major_formatter(lambda value, _: wording.significant(value, 1))
    bar.ax.xaxis.set_minor_formatter(lambda value, _: "")
    bar.set_label(f"{unit.in_brackets('distance')}, logarithmic")
    bar.outline.set_linewidth(0.4)
    figure.axes[0].set_ylabel("height [m]")
    return figure
