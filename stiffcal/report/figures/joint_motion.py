"""Each joint's six displacements over its wrench (001, Fig. 2a), and all joints about their own axes (2b)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.quantity import ANGLE, FORCE, LENGTH, MOMENT, ShownUnit
from stiffcal.report.figures import canvas
from stiffcal.report.joint_curves import JointCurve, JointPicture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 600
_LINE_POINTS = 121


@canvas.styled
def draw_joint(joint: JointPicture) -> Figure:
    """Draw one joint: three translations over forces above, three rotations over moments below.

    The same scale in each row, so that what is large looks large.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 66)
    panels = figure.subplots(2, 3)
    for row in range(2):
        row_curves = joint.curves[3 * row : 3 * row + 3]
        for panel, curve in zip(panels[row], row_curves, strict=True):
            _draw(panel, curve, joint.runs, joint.laws.get(curve.line.component))
            _label(panel, curve)
        _same_heights(panels[row], row_curves)
    canvas.share_legend(figure, _handles(joint.runs))
    return figure


@canvas.styled
def draw_about_axes(joints: Sequence[JointPicture]) -> Figure:
    """Draw every joint's turn about its own axis over its torque: the dominant compliances."""
    columns = min(3, len(joints))
    rows = -(-len(joints) // columns)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 44 * rows + 8)
    panels = figure.subplots(rows, columns, squeeze=False)
    for panel, joint in zip(panels.flat, joints, strict=False):
        _draw(panel, joint.curves[5], joint.runs, joint.laws.get("rz"))
        _label(panel, joint.curves[5])
        panel.set_title(f"{joint.name}: {_words(joint.curves[5])}")
        _same_heights([panel], [joint.curves[5]])
    for panel in list(panels.flat)[len(joints) :]:
        panel.set_axis_off()
    canvas.share_legend(figure, _handles(joints[0].runs))
    return figure


def _draw(
    panel: Axes, curve: JointCurve, runs: tuple[str, ...], law: tuple[NDArray[np.float64], NDArray[np.float64]] | None
) -> None:
    load_scale, moved_scale = (unit.factor for unit in _units(curve))
    canvas.zero_lines(panel)
    for number in range(len(runs)):
        in_run = np.flatnonzero((curve.run == number) & np.isfinite(curve.displacement))
        drawn_points = in_run[canvas.thinned(np.abs(curve.displacement[in_run]), MOST_POINTS // max(len(runs), 1))]
        panel.plot(
            curve.load[drawn_points] * load_scale, curve.displacement[drawn_points] * moved_scale, linestyle="none",
            marker=canvas.MARKERS[number % len(canvas.MARKERS)], markersize=1.7, markeredgewidth=0.4,
            color=canvas.COLOURS[number % len(canvas.COLOURS)], markerfacecolor="none", zorder=2,
        )  # fmt: skip
    c1, c2, c3 = (np.nan if value is None else value for value in curve.line.curve)
    if np.isfinite(c1) and curve.load.size:
        at = np.linspace(float(curve.load.min()), float(curve.load.max()), _LINE_POINTS)
        fitted = c1 * at + c2 * at**2 + c3 * at**3
        panel.plot(
            at * load_scale, fitted * moved_scale, color=canvas.MODEL, linewidth=1.2,
            linestyle="-" if curve.line.above_noise else (0, (2.0, 1.6)), zorder=4,
        )  # fmt: skip
    if law is not None:
        panel.plot(law[0] * load_scale, law[1] * moved_scale, color=canvas.ACCENT, linewidth=0.9, zorder=5)
    panel.locator_params(nbins=5)


def _label(panel: Axes, curve: JointCurve) -> None:
    axis = curve.line.component[1]
    turns = curve.line.component[0] == "r"
    load, moved = _units(curve)
    panel.set_xlabel(load.in_brackets(f"moment about {axis}" if turns else f"force along {axis}"))
    panel.set_ylabel(moved.in_brackets(f"rotation {axis}" if turns else f"translation {axis}"))
    panel.set_title(_words(curve))


def _words(curve: JointCurve) -> str:
    if curve.line.compliance is None:
        return "not loaded"
    if not curve.line.above_noise:
        return "not significant"
    return "significant, nonlinear" if curve.line.curved else "significant"


def _units(curve: JointCurve) -> tuple[ShownUnit, ShownUnit]:
    """Return the units of load and motion: usual ones, as panels of several joints are compared."""
    return (MOMENT.usual, ANGLE.usual) if curve.line.component[0] == "r" else (FORCE.usual, LENGTH.usual)


def _same_heights(panels: Sequence[Axes], curves: Sequence[JointCurve]) -> None:
    displacements = np.concatenate(
        [_units(curve)[1].factor * curve.displacement[np.isfinite(curve.displacement)] for curve in curves]
    )
    if displacements.size:
        largest = 1.08 * float(np.max(np.abs(displacements))) or 1.0
        for panel in panels:
            panel.set_ylim(-largest, largest)


def _handles(runs: tuple[str, ...]) -> list[object]:
    from matplotlib.lines import Line2D

    marks: list[object] = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=canvas.MARKERS[number % len(canvas.MARKERS)],
            markersize=3.0,
            color=canvas.COLOURS[number % len(canvas.COLOURS)],
            markerfacecolor="none",
            label=canvas.in_legend(name),
        )
        for number, name in enumerate(runs[:8])
    ]
    return [
        *marks,
        Line2D([], [], color=canvas.MODEL, linewidth=1.2, label="separately, significant"),
        Line2D(
            [], [], color=canvas.MODEL, linewidth=1.2, linestyle=(0, (2.0, 1.6)), label="separately, not significant"
        ),
        Line2D([], [], color=canvas.ACCENT, linewidth=0.9, label="all joints together"),
    ]
