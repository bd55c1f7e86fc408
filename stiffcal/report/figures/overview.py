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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiffcal.measurements.rms import Rms
    from stiffcal.report.content import PlaceShare, ReportRun

_LABEL_SIZE = (26, 6)
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
        ladder, robot = figure.subplots(1, 2, width_ratios=(1.75, 1.0))
        handles = fill_ladder(ladder, rungs, wording.part(noise, component), component, _LABEL_SIZE)
        _draw_robot(robot, run, shares)
    canvas.share_legend(figure, handles)
    return figure


_LABEL_AWAY_PT = 11.0
_SIDES: tuple[Literal["right", "center", "left"], ...] = ("right", "center", "left")
_SAME_M = 1e-3
"""Joints that are closer are drawn as one."""


def _free_corner(line: Floats) -> tuple[bool, bool]:
    """Return the corner of the picture that is farthest from the arm (n, 2): whether right, whether up."""
    span = np.maximum(np.ptp(line, axis=0), 1e-9)
    ends = (line - line.min(axis=0)) / span
    along = np.linspace(0.0, 1.0, 9)[:, None, None]
    points = (ends[None, :-1] + along * np.diff(ends, axis=0)[None]).reshape(-1, 2)
    corners = ((True, False), (False, False), (True, True), (False, True))
    return max(corners, key=lambda corner: float(np.linalg.norm(points - np.array(corner, float), axis=1).min()))


def _away_from_arm(line: Floats, at: Floats) -> Floats:
    """Return the direction (2,) in which a label at a place of the arm (n, 2) is farthest from its two neighbours."""
    away = np.zeros(2)
    nearest = int(np.argmin(np.linalg.norm(line - at, axis=1)))
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


def _draw_robot(axes: Axes, run: ReportRun, shares: Sequence[PlaceShare]) -> None:
    """Draw the arm from the side; circles have the area of their share of the deflection."""
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
    text = "\n".join(["share of the deflection", *(f"{place.label}  {100.0 * place.share:.0f} %" for place in written)])
    right, up = _free_corner(line)
    # room for the text next to the arm
    away = 1.3 * float(np.ptp(line, axis=0).max())
    beyond = line[:, 0].max() + away if right else line[:, 0].min() - away
    axes.plot([beyond], [line[:, 1].mean()], linestyle="none")
    axes.annotate(
        text, (float(right), float(up)), xycoords="axes fraction", ha="right" if right else "left",
        va="top" if up else "bottom", fontsize=6,
    )  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.22)
    axes.set_axis_off()
