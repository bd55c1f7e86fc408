"""Distances over the workspace before and after: with the robot file's robot, and with the identified one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEIGHT_MM = 78.0
_AREA = 7.0


@canvas.styled
def draw_calibration(place: Floats, before: Floats, after: Floats) -> Figure:
    """Draw where targets were measured, coloured by the distance between predicted and measured place.

    Parameters
    ----------
    place : (n, 3) m, base axes. before, after : (n,) m; each panel has colours of its own.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, _HEIGHT_MM, constrained=True)
    radius = np.hypot(place[:, 0], place[:, 1])
    titles = ("robot file, frames fitted", "identified, held-out regions")
    for axes, distance, title in zip(figure.subplots(1, 2, sharey=True), (before, after), titles, strict=True):
        order = np.argsort(distance)  # the farthest on top
        drawn = axes.scatter(
            radius[order], place[order, 2], c=1e3 * distance[order], s=_AREA, cmap="viridis", vmin=0.0,
            vmax=1e3 * float(np.quantile(distance, 0.99)), linewidths=0.0, rasterized=True,
        )  # fmt: skip
        axes.set_title(title)
        axes.set_xlabel("distance from the base's z axis [m]")
        axes.set_aspect("equal", adjustable="datalim")
        bar = figure.colorbar(drawn, ax=axes, location="bottom", shrink=0.9, aspect=28, extend="max")
        bar.set_label("distance [mm]")
        bar.outline.set_linewidth(0.4)
    figure.axes[0].set_ylabel("height [m]")
    return figure
