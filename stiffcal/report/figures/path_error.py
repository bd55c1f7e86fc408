"""The error along a path, with and without compensation (002, Fig. 9; 001, Fig. 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.compensate_result import PathError
from stiffcal.quantity import LENGTH
from stiffcal.report.figures import canvas
from stiffcal.report.figures.robot_poses import round_scale
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WITHOUT: dict[str, Any] = {
    "color": canvas.ACCENT,
    "linestyle": (0, (4.0, 1.5)),
    "linewidth": 1.2,
    "label": "without compensation",
}
_WITH: dict[str, Any] = {"color": canvas.COLOURS[0], "linestyle": "-", "linewidth": 1.4, "label": "with compensation"}
# Errors are drawn so large that the longest takes this share of the path's size.
_SHARE = 0.18


def shown_error(path: PathError, error: Floats) -> Floats:
    """Return (n,) the error as it is drawn: its part along the direction, or its length, m."""
    if path.direction is None:
        return np.asarray(np.linalg.norm(error, axis=1))
    return np.asarray(np.sum(path.direction * error, axis=1))


def half_width(path: PathError) -> Floats:
    """Return (n,) half the width of the band in which 95 % of what the model's uncertainty leaves lies, m."""
    if path.direction is None:
        return np.asarray(NORMAL_95 * np.sqrt(np.einsum("nii->n", path.covariance)))
    return np.asarray(NORMAL_95 * np.sqrt(np.einsum("ni,nij,nj->n", path.direction, path.covariance, path.direction)))


@canvas.styled
def draw_path_error(path: PathError) -> Figure:
    """Draw the path with its errors magnified, and the error over the way along it.

    Returns
    -------
    Figure; places, way and errors in the units of lengths.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 76)
    plan, along = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
    _draw_plan(plan, path)
    place, error = LENGTH.usual, canvas.unit_of(LENGTH, path.before, path.after)
    distance = place.factor * np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path.place, axis=0), axis=1))])
    canvas.zero_lines(along)
    along.plot(distance, error.factor * shown_error(path, path.before), **_WITHOUT)
    after, half = error.factor * shown_error(path, path.after), error.factor * half_width(path)
    along.plot(distance, after, **_WITH)
    handles = along.get_legend_handles_labels()[0]
    if half.any():
        low = after - half if path.direction is not None else np.maximum(after - half, 0.0)
        band = along.fill_between(
            distance,
            low,
            after + half,
            color=canvas.COLOURS[0],
            alpha=0.25,
            linewidth=0,
            label="model uncertainty (95 %)",
        )
        handles.append(band)
    along.set_xlabel(place.in_brackets("distance along the path"))
    along.set_ylabel(error.in_brackets(path.along))
    along.set_title(f"error, predicted by {path.judge}")
    canvas.share_legend(figure, handles)
    return figure


def _draw_plan(axes: Axes, path: PathError) -> None:
    """Draw the path in the base plane in which it is largest, with the errors magnified."""
    span = np.ptp(path.place, axis=0)
    i, j = sorted(np.argsort(span)[1:]) if np.sort(span)[1] > 0.02 * span.max() else _plane_of_line(path, span)
    size = float(np.linalg.norm(span))
    longest = float(max(np.abs(path.before[:, [i, j]]).max(), np.abs(path.after[:, [i, j]]).max()))
    scale = round_scale(longest, _SHARE * size)
    unit = LENGTH.usual
    axes.plot(
        unit.factor * path.place[:, i], unit.factor * path.place[:, j], color=canvas.INK, linewidth=0.8, label="wanted"
    )
    for error, style in ((path.before, _WITHOUT), (path.after, _WITH)):
        points = unit.factor * (path.place + scale * error)
        axes.plot(points[:, i], points[:, j], **{key: value for key, value in style.items() if key != "label"})
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set_xlabel(unit.in_brackets(canvas.AXES_NAMES[i]))
    axes.set_ylabel(unit.in_brackets(canvas.AXES_NAMES[j]))
    axes.set_title(f"path (thin), errors × {scale:g}")


def _plane_of_line(path: PathError, span: Floats) -> tuple[int, int]:
    """Return the axes of the plane that shows a straight path and most of its error."""
    first = int(np.argmax(span))
    other_axes = [axis for axis in range(3) if axis != first]
    direction = path.before if path.direction is None else path.direction
    second = max(other_axes, key=lambda axis: float(np.abs(direction[:, axis]).max()))
    i, j = sorted((first, second))
    return i, j
