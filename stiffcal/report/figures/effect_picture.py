"""What an effect does, on a simple example: the curve without it dashed, with it solid, the way back thinner."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.report.content import EffectPicture
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@canvas.styled
def draw_effect_picture(picture: EffectPicture) -> Figure:
    """Draw the picture by itself.

    Returns
    -------
    Figure; units as in the picture's labels.
    """
    figure = canvas.new_figure(90, 68)
    axes = figure.subplots()
    draw_on(axes, picture)
    canvas.share_legend(figure, axes.get_legend_handles_labels()[0])
    return figure


def draw_on(axes: Axes, picture: EffectPicture) -> None:
    """Draw the picture on a panel."""
    canvas.zero_lines(axes)
    _, first, index = np.unique(picture.x, return_index=True, return_inverse=True)
    if not np.array_equal(picture.without[first][index], picture.without):  # there and back on two curves
        first = np.arange(len(picture.x))
    axes.plot(
        picture.x[first],
        picture.without[first],
        color=canvas.QUIET,
        linestyle=(0, (4, 2)),
        linewidth=1.0,
        label="without",
        zorder=2,
    )
    loading, back = _parts(picture.unloading)
    blank = np.full_like(picture.with_effect, np.nan)
    axes.plot(
        picture.x, np.where(loading, picture.with_effect, blank), color=canvas.COLOURS[0], linewidth=1.3,
        label="with the effect", zorder=3,
    )  # fmt: skip
    if picture.unloading.any():
        axes.plot(
            picture.x, np.where(back, picture.with_effect, blank), color=canvas.ACCENT, linewidth=1.0,
            linestyle=(0, (5, 1)), label=picture.back, zorder=4,
        )  # fmt: skip
    axes.set_xlabel(picture.x_label)
    axes.set_ylabel(picture.y_label)


def _parts(unloading: Booleans) -> tuple[Booleans, Booleans]:
    """Return the points of each branch; the turning points to both, so that no gap is left."""
    on_unloading = unloading.copy()
    on_unloading[:-1] |= unloading[1:]
    loading = ~unloading
    loading[:-1] |= ~unloading[1:]
    return loading, on_unloading
