"""With and without compensation: load-deformation (002, Fig. 6), errors by pose (003, Fig. 7–9), and over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.quantity import LENGTH, of_component, of_load
from stiffcal.report.compensation_content import ComparedPose, TimePair, WithAndWithout
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OFF: dict[str, Any] = {"color": canvas.ACCENT, "marker": "s", "linestyle": (0, (4.0, 1.5))}
_ON: dict[str, Any] = {"color": canvas.COLOURS[0], "marker": "o", "linestyle": "-"}
_WITHOUT, _WITH = "without compensation", "with compensation"
_COMPONENTS = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")


@canvas.styled
def draw_before_and_after(pose: ComparedPose) -> Figure:
    """Draw deflection against force along each axis, without and with compensation.

    Returns
    -------
    Figure; forces in N, deflections in one unit, base axes.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 66)
    panels = figure.subplots(1, 3, sharey=True)
    unit = canvas.unit_of(LENGTH, pose.off.displacement, pose.on.displacement)
    for axis, (letter, panel) in enumerate(zip(canvas.AXES_NAMES, panels, strict=True)):
        canvas.zero_lines(panel)
        for half, style, label in ((pose.off, _OFF, _WITHOUT), (pose.on, _ON, _WITH)):
            along = _mostly_along(half.force, axis)
            panel.plot(
                half.force[along, axis], unit.factor * half.displacement[along, axis], linewidth=0.8, markersize=3.0,
                label=label, markerfacecolor="white" if half is pose.on else style["color"], **style,
            )  # fmt: skip
        panel.set_xlabel(f"force F{letter} [N]")
    panels[0].set_ylabel(unit.in_brackets("deflection along the same axis"))
    canvas.share_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def _mostly_along(force: Floats, axis: int) -> Integers:
    """Return the states whose load is mostly along an axis, with the unloaded ones between, in order."""
    size = np.linalg.norm(force, axis=1)
    along_axis = np.abs(force[:, axis]) > 0.7 * size
    idle = size < 0.02 * size.max(initial=1.0)
    adjacent = np.convolve(along_axis, [1, 1, 1], mode="same") > 0
    return np.flatnonzero((along_axis & ~idle) | (idle & adjacent))


@canvas.styled
def draw_errors_by_pose(pairs: WithAndWithout) -> Figure:
    """Draw the rms error of every pose without and with compensation: position, and orientation where measured.

    Returns
    -------
    Figure; one unit a panel.
    """
    has_rotation = all(np.isfinite([pose.error_off[1], pose.error_on[1]]).all() for pose in pairs.poses)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 62)
    panels = figure.subplots(1, 2 if has_rotation else 1, squeeze=False)[0]
    place = np.arange(len(pairs.poses))
    for component, panel in enumerate(panels):
        unit = of_component(3 * component).unit_for(pose.largest_off[component] for pose in pairs.poses)
        for side, (key, largest, style, hatch, label) in enumerate(
            (
                ("error_off", "largest_off", _OFF, "////", _WITHOUT),
                ("error_on", "largest_on", _ON, "", _WITH),
            )
        ):
            values = unit.factor * np.array([getattr(pose, key)[component] for pose in pairs.poses])
            top = unit.factor * np.array([getattr(pose, largest)[component] for pose in pairs.poses])
            at = place + (side - 0.5) * 0.38
            panel.bar(
                at, values, width=0.36, color="white" if hatch else style["color"], edgecolor=style["color"],
                hatch=hatch, label=label, linewidth=0.8,
            )  # fmt: skip
            panel.plot(at, top, linestyle="none", marker="_", markersize=8, color=canvas.INK, zorder=4)
        panel.set_xticks(place, [pose.off.name for pose in pairs.poses])
        panel.tick_params(axis="x", labelrotation=30.0 if len(place) > 4 else 0.0)
        panel.set_ylabel(unit.in_brackets(("position error", "orientation error")[component]))
        panel.grid(visible=False, axis="x")
    canvas.share_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure


@canvas.styled
def draw_step(pair: TimePair) -> Figure:
    """Draw force and displacement over time, without and with compensation.

    Returns
    -------
    Figure; s, N and a length.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 78)
    force, displacement_panel = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 1.5))
    unit = canvas.unit_of(LENGTH, pair.off.displacement, pair.on.displacement)
    for trace, style, label in ((pair.off, _OFF, _WITHOUT), (pair.on, _ON, _WITH)):
        line = {key: value for key, value in style.items() if key != "marker"}
        size = np.linalg.norm(trace.wrench[:, :3] - np.median(trace.wrench[:20, :3], axis=0), axis=1)
        force.plot(trace.time, size, linewidth=0.8, **line)
        displacement_panel.plot(trace.time, unit.factor * trace.displacement, linewidth=1.0, label=label, **line)
    if np.isfinite(pair.delay):
        for panel in (force, displacement_panel):
            panel.axvspan(0.0, pair.delay, color=canvas.PALE, zorder=0)
    stop = float(pair.on.time[np.linalg.norm(pair.on.wrench[:, :3], axis=1).argmax()]) + 1.5
    displacement_panel.set_xlim(max(float(pair.on.time[0]), -0.3), min(float(pair.on.time[-1]), max(stop, 1.0)))
    force.set_ylabel("force [N]")
    displacement_panel.set_ylabel(unit.in_brackets("displacement"))
    displacement_panel.set_xlabel("time since load application [s]")
    canvas.share_legend(figure, displacement_panel.get_legend_handles_labels()[0])
    return figure


@canvas.styled
def draw_process(pair: TimePair) -> Figure:
    """Draw all components of the wrench over time, without and with compensation (003, Fig. 10, 11).

    Returns
    -------
    Figure; s, N and N·m, the sensor's axes.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 96)
    panels = figure.subplots(2, 3, sharex=True)
    for number, (name, panel) in enumerate(zip(_COMPONENTS, panels.ravel(), strict=True)):
        for trace, style, label in ((pair.off, _OFF, _WITHOUT), (pair.on, _ON, _WITH)):
            line = {key: value for key, value in style.items() if key != "marker"}
            panel.plot(trace.time, trace.wrench[:, number], linewidth=0.8, label=label, **line)
        panel.set_title(of_load(number).usual.in_brackets(name))
    for panel in panels[1]:
        panel.set_xlabel("time since half of the force [s]")
    canvas.share_legend(figure, panels[0, 0].get_legend_handles_labels()[0])
    return figure
