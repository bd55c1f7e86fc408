"""The picture of the first page: the ladder of fits, and the robot with the places that give most."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.report import wording
from stiffcal.report.figures import canvas
from stiffcal.report.figures.ladder import Rung, fill_ladder, label_lines
from stiffcal.report.figures.robot_poses import side_view
from stiffcal.wording import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiffcal.measurements.rms import Rms
    from stiffcal.report.content import PlaceShare, ReportRun

_LABEL_SIZE = (28, 4)
MOST_RUNGS = 8
# Shares of the deflection below this get no number.
_LEAST_WRITTEN, _MOST_WRITTEN = 0.01, 8


@canvas.styled
def draw_overview(
    rungs: Sequence[Rung],
    noise: Rms | None,
    run: ReportRun | None,
    shares: Sequence[PlaceShare],
    component: str = "translation",
) -> Figure:
    """Draw the ladder, and next to it the robot with each joint's share of the deflection.

    Parameters
    ----------
    rungs : from the top down. noise : as for `draw_ladder`.
    run : the pose in which the robot is drawn; None: the ladder alone.
    shares : share of the target's deflection by place.
    component : as for `draw_ladder`.

    Returns
    -------
    Figure; mm, m.
    """
    lines = max(len(label_lines(rung.label, _LABEL_SIZE)) for rung in rungs)
    height = 22.0 + max(7.0, 2.9 * lines) * len(rungs)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, max(height, 45.0 if run is not None else 0.0))
    if run is None:
        handles = fill_ladder(figure.subplots(), rungs, wording.part(noise, component), component, _LABEL_SIZE)
    else:
        ladder, robot, numbers = figure.subplots(1, 3, width_ratios=(1.6, 0.6, 0.55))
        handles = fill_ladder(ladder, rungs, wording.part(noise, component), component, _LABEL_SIZE)
        _draw_robot(robot, numbers, run, shares)
    canvas.share_legend(figure, handles)
    return figure


_LABEL_AWAY_PT = 11.0
_SIDES: tuple[Literal["right", "center", "left"], ...] = ("right", "center", "left")
_SAME_M = 1e-3
"""Joints that are closer are drawn as one."""


def _away_from_arm(line: Floats, at: Floats) -> Floats:
    """Return the direction (2,) in which a label at a place of the arm (n, 2) is farthest from its two neighbours."""
    nearest = int(np.argmin(np.linalg.norm(line - at, axis=1)))
    if float(np.linalg.norm(line[nearest] - at)) > _SAME_M:
        return _across_the_link(line, at)
    away = np.zeros(2)
    for side in (line[nearest::-1], line[nearest:]):
        length = np.linalg.norm(side - at, axis=1)
        if (length > _SAME_M).any():
            next_one = int(np.argmax(length > _SAME_M))
            away -= (side[next_one] - at) / length[next_one]
    if np.linalg.norm(away) < 0.2:  # the arm goes straight on: across it
        along = line[min(nearest + 1, len(line) - 1)] - line[max(nearest - 1, 0)]
        # to the right: the errors of the fits are on the left
        away = np.array([abs(along[1]), -along[0] * np.sign(along[1])])
    size = float(np.linalg.norm(away))
    return away / size if size else np.array([0.0, 1.0])


def _across_the_link(line: Floats, at: Floats) -> Floats:
    """Return the direction (2,) across the link on which a place lies, away from the rest of the arm (n, 2)."""
    begin, along = line[:-1], np.diff(line, axis=0)
    share = np.clip(np.sum((at - begin) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-12), 0.0, 1.0)
    link = along[int(np.argmin(np.linalg.norm(begin + share[:, None] * along - at, axis=1)))]
    across = np.array([link[1], -link[0]]) / max(float(np.linalg.norm(link)), 1e-12)
    return across if float(across @ (at - line.mean(axis=0))) >= 0.0 else -across


def _draw_robot(axes: Axes, numbers: Axes, run: ReportRun, shares: Sequence[PlaceShare]) -> None:
    """Draw the arm from the side, each share of the deflection as the area of a circle; its numbers next to it."""
    stick = run.stick
    assert stick is not None
    points = stick @ side_view(stick).T
    end = points[-1:] if run.target is None else run.target[None] @ side_view(stick).T
    line = np.concatenate([points, end])
    axes.plot(line[:, 0], line[:, 1], color=canvas.INK, linewidth=1.3, solid_joinstyle="round", zorder=2)
    at: dict[tuple[float, float], float] = defaultdict(float)
    names: dict[tuple[float, float], list[str]] = defaultdict(list)
    for place in shares:
        if place.joint is None:
            continue
        centre = points[place.joint]
        if place.beyond_joint:
            centre = 0.5 * (centre + points[min(place.joint + 1, len(points) - 1)])
        key = (round(float(centre[0]), 4), round(float(centre[1]), 4))
        at[key] += max(place.share, 0.0)
        names[key].append(place.mark)
    for (x, y), share in at.items():
        size = 2.0 + 15.0 * float(np.sqrt(share))
        axes.plot(x, y, marker="o", markersize=size, color=canvas.ACCENT, alpha=0.55, zorder=3)
        axes.plot(x, y, marker="o", markersize=2.0, color=canvas.INK, zorder=4)
    for (x, y), marks in names.items():
        aside = _LABEL_AWAY_PT * _away_from_arm(line, np.array([x, y]))
        axes.annotate(
            ", ".join(sorted(marks)), (x, y), xytext=(float(aside[0]), float(aside[1])), textcoords="offset points",
            ha=_SIDES[1 + int(np.sign(round(float(aside[0]) / _LABEL_AWAY_PT)))], va="center",
            fontsize=6, zorder=5,
        )  # fmt: skip
    written = [place for place in shares if place.share >= _LEAST_WRITTEN][:_MOST_WRITTEN]
    text = "\n".join(["share of the deflection", *(f"{place.label}  {percent(place.share)}" for place in written)])
    numbers.annotate(text, (1.0, 0.5), xycoords="axes fraction", ha="right", va="center", fontsize=6)
    numbers.set_axis_off()
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(x=0.5, y=0.35)  # room for the labels
    axes.set_axis_off()
