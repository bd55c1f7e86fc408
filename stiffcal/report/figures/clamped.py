"""The clamped robot in pictures (004, Fig. 5 to 8): branches with their play, torque over angle, play by pose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.report.clamped_curves import ClampedCurve, ClampedPose
from stiffcal.report.figures import canvas
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROW_MM = 52.0


def _grid(curves: tuple[ClampedCurve, ...]) -> tuple[Figure, list[Axes]]:
    rows = (len(curves) + 1) // 2
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, ROW_MM * rows + 10)
    panels = figure.subplots(rows, 2, squeeze=False).ravel().tolist()
    for spare in panels[len(curves) :]:
        spare.set_axis_off()
    return figure, panels


@canvas.styled
def draw_branches(curves: tuple[ClampedCurve, ...]) -> Figure:
    """Draw torque over angle of every joint in the pose that moved it furthest: both branches, the law, the play."""
    figure, panels = _grid(curves)
    for panel, curve in zip(panels, curves, strict=False):
        pose = curve.shown
        _branches(panel, pose)
        panel.set_title(f"{curve.joint}, run {pose.run}" + (" (left out)" if pose.left_out else ""))
    _share_legend(figure, panels)
    return figure


def _branches(panel: Axes, pose: ClampedPose) -> None:
    if pose.low is not None and pose.high is not None:
        panel.axvspan(
            np.rad2deg(pose.low), np.rad2deg(pose.high), color=canvas.PALE, linewidth=0, label="play", zorder=0
        )
    for way, marker, colour, words in (
        (True, "^", canvas.COLOURS[0], "angle growing"),
        (False, "v", canvas.COLOURS[1], "angle falling"),
    ):
        own = np.flatnonzero(pose.up == way)
        order = own[np.argsort(pose.angle[own])]
        angle = np.rad2deg(pose.angle[order])
        panel.plot(
            angle, pose.torque[order], linestyle="none", marker=marker, markersize=2.4, markerfacecolor="none",
            markeredgewidth=0.6, color=colour, label=words, zorder=3,
        )  # fmt: skip
        panel.plot(angle, pose.fitted[order], color=canvas.MODEL, linewidth=0.9, label="fit", zorder=4)
    panel.set_xlabel("angle, arm against motor [°]")
    panel.set_ylabel("torque on the joint [N·m]")


@canvas.styled
def draw_curves(curves: tuple[ClampedCurve, ...]) -> Figure:
    """Draw the torque-angle curve of every joint, counted from the flank, with the readings of all poses used."""
    figure, panels = _grid(curves)
    for panel, curve in zip(panels, curves, strict=False):
        used = [pose for pose in curve.poses if pose.run in curve.curve_runs]
        for number, pose in enumerate(used):
            panel.plot(
                np.rad2deg(pose.spring_angle), pose.spring_torque, linestyle="none", markersize=2.2,
                marker=canvas.MARKERS[number % len(canvas.MARKERS)], markerfacecolor="none", markeredgewidth=0.5,
                color=canvas.COLOURS[number % len(canvas.COLOURS)], label=canvas.in_legend(pose.run), zorder=2,
            )  # fmt: skip
        angle = np.rad2deg(curve.angle)
        half = NORMAL_95 * curve.std
        panel.fill_between(angle, curve.torque - half, curve.torque + half, color=canvas.PALE, linewidth=0, zorder=1)
        panel.plot(angle, curve.torque, color=canvas.MODEL, linestyle="--", linewidth=1.1, zorder=4)
        canvas.zero_lines(panel)
        panel.set_title(curve.joint)
        panel.locator_params(axis="x", nbins=5)
        panel.set_xlabel("angle from the flank [°]")
        panel.set_ylabel("torque [N·m]")
        if used:
            panel.legend(loc="upper left", handletextpad=0.2, borderpad=0.2)
    return figure


@canvas.styled
def draw_play_by_pose(curves: tuple[ClampedCurve, ...]) -> Figure:
    """Draw the play that each pose gives of each joint, with what it is known to; poses left out as crosses."""
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 70.0)
    panel = figure.subplots(1, 1)
    for place, curve in enumerate(curves):
        seen = [pose for pose in curve.poses if pose.play is not None]
        spots = place + (np.arange(len(seen)) - 0.5 * (len(seen) - 1)) * min(0.22, 0.7 / max(len(seen), 1))
        if curve.result is not None:
            play = float(np.rad2deg(curve.result.play))
            panel.plot(
                [place - 0.42, place + 0.42], [play, play], color=canvas.MODEL, linewidth=1.0, label="joint", zorder=1
            )
        for x, pose in zip(spots, seen, strict=True):
            crossed = bool(pose.left_out)
            panel.errorbar(
                x, np.rad2deg(pose.play or 0.0), yerr=np.rad2deg(pose.doubt), linestyle="none", capsize=2.0,
                marker="x" if crossed else "o", markersize=4.5, markerfacecolor="none", elinewidth=0.7,
                color=canvas.COLOURS[1] if crossed else canvas.COLOURS[0],
                label="pose, left out" if crossed else "pose, used", zorder=3,
            )  # fmt: skip
            panel.annotate(
                pose.run, (x, np.rad2deg(pose.play or 0.0)), xytext=(0, 7), textcoords="offset points", ha="center",
                va="bottom", rotation=90, fontsize=5.0, color=canvas.QUIET,
            )  # fmt: skip
    panel.set_xticks(range(len(curves)), [curve.joint for curve in curves])
    panel.set_xlim(-0.6, len(curves) - 0.4)
    low, high = panel.get_ylim()
    panel.set_ylim(min(low, 0.0), high + 0.3 * (high - min(low, 0.0)))
    panel.set_ylabel("play [°]")
    _share_legend(figure, [panel])
    return figure


def _share_legend(figure: Figure, panels: list[Axes]) -> None:
    handles: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    canvas.share_legend(figure, list(handles.values()))
