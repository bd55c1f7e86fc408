"""The robot drawn in its poses as a stick figure, with the residuals as arrows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.report import wording
from stiffcal.report.content import ReportRun, ReportStates
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Parallel projection: the eye stands this far to the side of where the arm mostly points, and this high, degrees.
_ASIDE, _ELEVATION = 60.0, 22.0
_ARROWS_PER_RUN = 6


def residual_arrows(states: ReportStates, run: int) -> tuple[Floats, Floats]:
    """Pick the residuals to draw in a run: the state of the largest load in each direction of force.

    Returns
    -------
    force (m, 3) N and residual (m, 3) m, base axes; m at most six, the largest residuals first.
    """
    inside = np.flatnonzero(states.used & (states.run == run))
    picks = []
    labels = list(dict.fromkeys(states.direction[inside].tolist()))
    for label in [label_text for label_text in labels if label_text] or labels:
        members = inside[states.direction[inside] == label]
        picks.append(int(members[np.argmax(states.load[members])]))
    residual = states.residual[:, :3]
    picks.sort(key=lambda index: -float(np.linalg.norm(residual[index])))
    chosen = np.array(picks[:_ARROWS_PER_RUN], dtype=np.int64)
    return states.force[chosen], residual[chosen]


def round_scale(longest: float, size: float) -> float:
    """Magnification (1, 2 or 5 times a power of ten) that draws `longest` metres not longer than `size` metres.

    Examples
    --------
    >>> round_scale(1e-4, 0.35)
    2000.0
    """
    if longest <= 0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(size / longest))
    return float(next(step * decade for step in (5.0, 2.0, 1.0) if step * decade * longest <= size))


def _view(azimuth: float, elevation: float) -> Floats:
    """(2, 3): base axes to the plane of the picture (right, up)."""
    a, e = np.deg2rad(azimuth), np.deg2rad(elevation)
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    up = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
    return np.stack([right, up])


def side_view(stick: Floats) -> Floats:
    """Return (2, 3) base axes to a picture in which an arm (K, 3) lies from left to right, seen horizontally."""
    reach = stick[-1] - stick[0]
    return _view(float(np.rad2deg(np.arctan2(reach[1], reach[0]))) - 90.0, 0.0)


def _draw_stick(axes: Axes, stick: Floats, colour: str, width: float, joints: bool = True) -> None:
    axes.plot(stick[:, 0], stick[:, 1], color=colour, linewidth=width, solid_joinstyle="round", zorder=2)
    if joints:
        axes.plot(
            stick[1:-1, 0], stick[1:-1, 1], linestyle="none", marker="o", markersize=2.4, color=colour,
            markerfacecolor="white", zorder=3,
        )  # fmt: skip


def _draw_arrows(axes: Axes, start: Floats, vectors: Floats, width: float = 0.8) -> None:
    for vector in vectors:
        axes.annotate(
            "", xy=tuple(start + vector), xytext=tuple(start), annotation_clip=False,
            arrowprops={"arrowstyle": "-|>", "color": canvas.ARROW, "linewidth": width, "mutation_scale": 4,
                        "shrinkA": 0, "shrinkB": 0}, zorder=5,
        )  # fmt: skip


def _reach(runs: Sequence[ReportRun]) -> float:
    """Size of the drawn space, m: the largest distance of any joint from the base."""
    return max(float(np.linalg.norm(run.stick, axis=1).max()) for run in runs if run.stick is not None)


def arrow_scale(runs: Sequence[ReportRun], states: ReportStates) -> float:
    """Magnification of the residual arrows that suits these runs: single arrows may be longer than whole bunches."""
    drawn = [number for number, run in enumerate(runs) if run.stick is not None]
    most = max((len(residual_arrows(states, number)[1]) for number in drawn), default=0)
    share = 0.15 if most > 1 else 0.3
    longest = max(
        (
            float(np.linalg.norm(residual, axis=1).max(initial=0.0))
            for _, residual in (residual_arrows(states, n) for n in drawn)
        ),
        default=0.0,
    )
    return round_scale(longest, share * _reach([runs[n] for n in drawn]))


def _end(run: ReportRun) -> Floats:
    assert run.stick is not None
    return run.stick[-1] if run.target is None else run.target


@canvas.styled
def draw_pose_sheet(
    runs: Sequence[ReportRun], numbers: Sequence[int], states: ReportStates | None, scale: float, columns: int = 4
) -> Figure:
    """Draw each pose in a small picture of its own, in side view and top view, its shadow on the floor.

    Parameters
    ----------
    runs : all runs.
    numbers : indices of the runs to draw.
    states : the load states; None draws no arrows.
    scale : magnification of the arrows.
    columns : pictures side by side.

    Returns
    -------
    Figure; one scale for all, a bar of that length in m in the last picture.
    """
    rows = -(-len(numbers) // columns)
    view = _view(_azimuth(runs) - _ASIDE, _ELEVATION)
    tips = [
        _end(runs[number]) + scale * vector
        for number in numbers if states is not None
        for vector in residual_arrows(states, number)[1]
    ]  # fmt: skip
    low, high = _extent(runs, numbers, view, tips)
    cell = canvas.PAGE_WIDTH_MM / columns
    height = cell * float(np.clip((high - low)[1] / (high - low)[0], 0.6, 1.0)) + 4
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, rows * height + 6)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel in panels:
        panel.set_axis_off()
        panel.set_aspect("equal")
        panel.set_xlim(low[0], high[0])
        panel.set_ylim(low[1], high[1])
    for panel, number in zip(panels, numbers, strict=False):
        run = runs[number]
        assert run.stick is not None
        points = np.concatenate([run.stick, _end(run)[None]])
        _draw_stick(panel, points * [1.0, 1.0, 0.0] @ view.T, canvas.PALE, 1.4, joints=False)
        _draw_stick(panel, points @ view.T, canvas.INK, 1.1)
        if states is not None:
            _, residual = residual_arrows(states, number)
            _draw_arrows(panel, view @ _end(run), scale * residual @ view.T)
        panel.set_title(run.name, fontsize=6.5, loc="center", pad=1)
    _draw_axes(panels[0], view, 0.22 * float((high - low)[1]))
    _draw_ruler(panels[len(numbers) - 1], low, scale if states is not None else None)
    return figure


def _azimuth(runs: Sequence[ReportRun]) -> float:
    """Where the arm mostly points, degrees about the base's z axis."""
    reach = np.sum([_end(run)[:2] for run in runs if run.stick is not None], axis=0)
    return float(np.rad2deg(np.arctan2(reach[1], reach[0])))


def _extent(
    runs: Sequence[ReportRun], numbers: Sequence[int], view: Floats, tips: Sequence[Floats]
) -> tuple[Floats, Floats]:
    """Corners (2,) of the picture that holds all robots, shadows and tips of arrows, with room for a ruler."""
    drawn = [np.concatenate([stick, _end(runs[n])[None]]) for n in numbers if (stick := runs[n].stick) is not None]
    shapes = [shape for outline in drawn for shape in (outline, outline * [1.0, 1.0, 0.0])]
    points = np.concatenate([*shapes, np.reshape(tips, (-1, 3))]) @ view.T
    size = float(np.ptp(points, axis=0).max())
    room = np.array([0.12, 0.06]) * size
    return points.min(axis=0) - room - [0.0, 0.12 * size], points.max(axis=0) + room


def _draw_axes(axes: Axes, view: Floats, size: float) -> None:
    """Draw the base axes at the robot's foot."""
    for letter, direction in zip(canvas.AXES_NAMES, np.eye(3), strict=True):
        tip = view @ direction * size
        axes.plot([0.0, tip[0]], [0.0, tip[1]], color=canvas.COLOURS[0], linewidth=0.7, zorder=1)
        # the robot's column stands on the axis that points upwards
        aside = -4.0 if letter == "z" else 0.0
        axes.annotate(
            letter, tuple(tip if aside else 1.25 * tip), xytext=(aside, 0.0), textcoords="offset points",
            ha="center", va="center", fontsize=6, color=canvas.COLOURS[0],
        )  # fmt: skip


def _draw_ruler(axes: Axes, low: Floats, scale: float | None) -> None:
    """Draw a bar of half a metre, and what it means for the arrows."""
    text = "0.5 m" if scale is None else f"0.5 m; for arrows {wording.length(0.5 / scale)}"
    right, height = axes.get_xlim()[1], low[1] + 0.1 * (axes.get_ylim()[1] - low[1])
    axes.plot([right - 0.5, right], [height] * 2, color=canvas.INK, linewidth=1.8, solid_capstyle="butt")
    # both end with the panel: the text may be longer than the bar, and the panel is the last of its row
    axes.annotate(text, (right, height), xytext=(0, -3), textcoords="offset points", ha="right", va="top", fontsize=6)
