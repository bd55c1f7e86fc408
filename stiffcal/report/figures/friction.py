"""Friction torque over velocity (004, Fig. 4's kind): the slow range, where Stribeck friction lies, and the whole."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.report.figures import canvas
from stiffcal.report.friction_curves import FrictionCurve
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The slow range is drawn apart where readings lie below this share of the fastest: 004 measured 1 to 5 %, then 10 to
# 100 %.
SLOW = 0.08
ROW_MM = 46.0


def slow_limit(curve: FrictionCurve) -> float | None:
    """Return up to which speed, rad/s, the slow panel goes; None where nothing was measured there.

    Examples
    --------
    >>> x = np.array([0.01, 0.05, 0.5, 1.0])
    >>> slow_limit(FrictionCurve("A1", True, x, x, x, x, x, (), (), 0.0, None))
    0.055
    """
    speed = np.abs(curve.velocity)
    slow = speed[speed < SLOW * speed.max()]
    return round(1.1 * float(slow.max()), 6) if slow.size else None


@canvas.styled
def draw_friction(curves: tuple[FrictionCurve, ...]) -> Figure:
    """Draw friction over speed for every joint: a row each, the slow range left, all speeds right.

    Both directions are folded onto positive speeds: triangles up one way, down the other. The band is the curve's 95 %
    interval.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, ROW_MM * len(curves) + 8)
    rows = figure.subplots(len(curves), 2, squeeze=False, gridspec_kw={"width_ratios": [1.0, 1.6]})
    for (slow, whole), curve in zip(rows, curves, strict=True):
        limit = slow_limit(curve)
        _draw(whole, curve, None)
        whole.set_title(f"{curve.joint}: all speeds")
        if limit is None:
            slow.set_axis_off()
            slow.text(0.5, 0.5, "no slow speeds were measured", ha="center", va="center", color=canvas.QUIET)
            continue
        _draw(slow, curve, limit)
        slow.set_title(f"{curve.joint}: slow")
    handles = {
        label: handle for panel in rows.flat for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    canvas.share_legend(figure, list(handles.values()))
    return figure


def _draw(panel: Axes, curve: FrictionCurve, limit: float | None) -> None:
    speed = np.abs(curve.velocity)
    friction = curve.friction * np.sign(curve.velocity)
    shown = speed <= (np.inf if limit is None else limit)
    fitted = curve.speed <= (np.inf if limit is None else limit)
    size, alpha = (3.4, 1.0) if curve.steady else (1.4, 0.45)
    for way, marker, colour, words in (
        (1.0, "^", canvas.COLOURS[0], "measured, forward"),
        (-1.0, "v", canvas.COLOURS[1], "measured, backward"),
    ):
        own = shown & (np.sign(curve.velocity) == way)
        panel.plot(
            speed[own], friction[own], linestyle="none", marker=marker, markersize=size, color=colour, alpha=alpha,
            markerfacecolor="none" if curve.steady else colour, label=words, zorder=3,
        )  # fmt: skip
    low, high = (curve.fitted + sign * NORMAL_95 * curve.std for sign in (-1.0, 1.0))
    panel.fill_between(
        curve.speed[fitted], low[fitted], high[fitted], color=canvas.PALE, linewidth=0, label="95 % interval", zorder=1
    )
    panel.plot(curve.speed[fitted], curve.fitted[fitted], color=canvas.MODEL, linewidth=1.1, label="fit", zorder=4)
    panel.set_xlim(0.0, limit if limit is not None else 1.04 * float(speed.max()))
    panel.set_ylim(*_range(friction[shown], low[fitted], high[fitted], zero=limit is None))
    panel.locator_params(axis="x", nbins=6)
    panel.set_xlabel("speed [rad/s]")
    panel.set_ylabel("friction torque [N·m]")


def _range(*values: np.ndarray, zero: bool) -> tuple[float, float]:
    """Return the ends of the torque axis: from zero where all speeds are shown, else closely around the readings."""
    everything = np.concatenate([each for each in values if each.size] or [np.zeros(1)])
    low, high = float(everything.min()), float(everything.max())
    margin = 0.08 * max(high - low, 0.02 * abs(high), 1e-9)
    return (min(0.0, low - margin) if zero else low - margin), high + margin
