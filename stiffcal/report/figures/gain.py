"""What more runs bring: the largest uncertainty against the number of runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stiffcal.planning.results import GainPoint


@canvas.styled
def draw_gain(gain: list[GainPoint]) -> Figure:
    """Draw the largest relative half width after the first runs of highest rank, in per cent, logarithmic.

    Parameters
    ----------
    gain : after 1, 2, … runs; points without a value are left out.
    """
    from matplotlib.figure import Figure

    known = [(point.runs, 100.0 * point.worst_relative) for point in gain if point.worst_relative is not None]
    figure = Figure(figsize=(canvas.PAGE_WIDTH_MM / 25.4, 2.2), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(*zip(*known, strict=True), marker="o", color=canvas.COLOURS[0])
    axes.set_yscale("log")
    axes.set_xlim(0, len(gain) + 1)
    axes.set_xlabel("runs, highest rank first")
    axes.set_ylabel("largest half width [%]")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}")
    return figure
