"""Friction torque over velocity (004, Fig. 4's kind): the slow range, where Stribeck friction lies, and the whole."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.departures import Departure, departure_bars, departures_in_words, find_departures
from stiffcal.kinds.friction.answers.curves import FrictionCurve
from stiffcal.presentation.values import Band, Digits, Line, Marks, Names, Panel, Picture, Series, Words
from stiffcal.uncertainty import NORMAL_95

# The slow range is drawn apart where readings lie below this share of the fastest: 004 measured 1 to 5 %, then 10 to
# 100 %.
SLOW = 0.08
_ROW_MM = 34.0


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


def friction_picture(curves: tuple[FrictionCurve, ...]) -> Picture:
    """Return friction over speed of every joint: a row each, the slow range left, all speeds right.

    Both directions are folded onto positive speeds: triangles up one way, down the other. The band is the curve's 95 %
    interval.
    """
    panels: list[Panel] = []
    for curve in curves:
        limit = slow_limit(curve)
        if limit is None:
            panels.append(Panel("", "", "", (), empty="no slow speeds were measured", joint=curve.joint))
        else:
            panels.append(_panel(curve, limit, f"{curve.joint}: slow"))
        panels.append(_panel(curve, None, f"{curve.joint}: all speeds"))
    fastest = max(float(abs(curve.velocity).max()) for curve in curves)
    of_joints = [(curve.joint, departures(curve)) for curve in curves]
    caption: Words = (
        "Friction torque over speed of ", Names(tuple(curve.joint for curve in curves)), ", up to ", Digits(fastest),
        (" rad/s: measured in both directions (mirrored to positive speeds), fitted law, and its 95 % interval. "
        "Left: slow range on a separate scale."),
        *departures_in_words(of_joints, "rad/s"),
    )  # fmt: skip
    height = _ROW_MM * len(curves) + 8
    return Picture(tuple(panels), columns=2, height=height, caption=caption, widths=(1.0, 1.6))


def departures(curve: FrictionCurve) -> list[Departure]:
    """Return where the readings leave the 95 % interval of the fitted curve, over speed in rad/s and in N·m."""
    speed = np.abs(curve.velocity)
    residual = curve.friction * np.sign(curve.velocity) - np.interp(speed, curve.speed, curve.fitted)
    return find_departures(speed, residual, NORMAL_95 * np.interp(speed, curve.speed, curve.std))


def _panel(curve: FrictionCurve, limit: float | None, title: str) -> Panel:
    speed = np.abs(curve.velocity)
    friction = curve.friction * np.sign(curve.velocity)
    in_range = speed <= (np.inf if limit is None else limit)
    fitted = curve.speed <= (np.inf if limit is None else limit)
    size, opacity = (3.4, 1.0) if curve.steady else (1.4, 0.45)
    series: list[Series] = []
    for direction, marker, colour, label in ((1.0, "^", 0, "measured, forward"), (-1.0, "v", 1, "measured, backward")):
        chosen = in_range & (np.sign(curve.velocity) == direction)
        series.append(
            Marks(
                speed[chosen], friction[chosen], marker, colour, size=size, is_hollow=curve.steady, opacity=opacity,
                label=label, rows=None if curve.rows is None else curve.rows[chosen],
            )
        )  # fmt: skip
    low, high = (curve.fitted + sign * NORMAL_95 * curve.std for sign in (-1.0, 1.0))
    series.append(Band(curve.speed[fitted], low[fitted], high[fitted], label="95 % interval"))
    series.append(Line(curve.speed[fitted], curve.fitted[fitted], label="fit"))
    series += departure_bars(curve.speed, curve.fitted, fitted, departures(curve), label="mean, outside the band")
    return Panel(
        title, "speed [rad/s]", "friction torque [N·m]", tuple(series),
        x_limits=(0.0, limit if limit is not None else 1.04 * float(speed.max())),
        y_limits=_range(friction[in_range], low[fitted], high[fitted], zero=limit is None),
        x_ticks=6, joint=curve.joint,
    )  # fmt: skip


def _range(*values: Floats, zero: bool) -> tuple[float, float]:
    """Return the ends of the torque axis: from zero where all speeds are shown, else closely around the readings."""
    everything = np.concatenate([numbers for numbers in values if numbers.size] or [np.zeros(1)])
    low, high = float(everything.min()), float(everything.max())
    margin = 0.08 * max(high - low, 0.02 * abs(high), 1e-9)
    return (min(0.0, low - margin) if zero else low - margin), high + margin
