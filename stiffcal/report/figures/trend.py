"""The parameters of one robot over many campaigns, and their control charts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.report.figures import canvas
from stiffcal.wording import superscript

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiffcal.validation.trend_result import TrendParameter, TrendResult

PANEL_MM = 32.0
COLUMNS = 2
MOST_PANELS = 24


@canvas.styled
def draw_trend(result: TrendResult) -> Figure:
    """Draw each parameter with its 95 % interval over the campaigns, those with an alarm first.

    Parameters
    ----------
    result : of ``trend``; at most `MOST_PANELS` parameters are drawn.
    """
    chosen = sorted(result.parameters, key=lambda parameter: parameter.alarm is None)[:MOST_PANELS]
    rows = math.ceil(len(chosen) / COLUMNS)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, PANEL_MM * rows + 12.0, constrained=True)
    labels = [campaign.date or str(number) for number, campaign in enumerate(result.campaigns, start=1)]
    for number, parameter in enumerate(chosen):
        axes = figure.add_subplot(rows, COLUMNS, number + 1)
        _panel(axes, parameter)
        _label_campaigns(axes, labels, last=number >= len(chosen) - COLUMNS)
    return figure


def _panel(axes: Axes, parameter: TrendParameter) -> None:
    known = [(k, one) for k, one in enumerate(parameter.values) if one is not None and one.value is not None]
    exponent = math.floor(math.log10(max((abs(one.value or 0.0) for _, one in known), default=1.0) or 1.0))
    scale = 10.0**-exponent
    x = [float(k) for k, _ in known]
    middle = [scale * (one.value or 0.0) for _, one in known]
    ends = [one.interval or [one.value, one.value] for _, one in known]
    below = [
        max(value - scale * (end[0] if end[0] is not None else math.nan), 0.0)
        for value, end in zip(middle, ends, strict=True)
    ]
    above = [
        max(scale * (end[1] if end[1] is not None else math.nan) - value, 0.0)
        for value, end in zip(middle, ends, strict=True)
    ]
    axes.errorbar(
        x, middle, yerr=[below, above], fmt="o", color=canvas.COLOURS[0], capsize=1.5, linestyle="-", linewidth=0.6
    )
    alarm = "" if parameter.alarm is None else ", alarm"
    if parameter.alarm is not None and parameter.changed_from is not None:
        axes.axvline(parameter.changed_from - 0.5, color=canvas.ACCENT, linestyle="--", linewidth=0.8)
        axes.plot(
            [parameter.alarm],
            [middle[x.index(float(parameter.alarm))]],
            marker="D",
            markersize=6.0,
            zorder=3,
            color=canvas.ACCENT,
            linestyle="",
        )
    place = parameter.name.split(".", 1)[1].rsplit(".", 1)[0]
    axes.set_title(f"{parameter.effect} {place}{alarm}")
    power = f"10{superscript(exponent)} " if exponent else ""
    axes.set_ylabel(f"{power}{parameter.unit}")


def _label_campaigns(axes: Axes, labels: Sequence[str], last: bool) -> None:
    shown = np.linspace(0, len(labels) - 1, 6).round() if len(labels) > 6 else range(len(labels))
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_xticks([int(number) for number in shown])
    axes.set_xticklabels([labels[int(number)] for number in shown] if last else [])
    if last:
        axes.set_xlabel("campaign")
