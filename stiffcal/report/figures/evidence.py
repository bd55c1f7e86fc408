"""The evidence for an effect: residual over its covariate without and with it, next to the course of such an effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.quantity import JOINT_ANGLE, ShownUnit, of_measure
from stiffcal.report.content import EvidenceFigure
from stiffcal.report.figures import canvas
from stiffcal.report.figures.effect_picture import draw_on

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 900
_BRANCHES = (("loading", "o", True), ("unloading", "s", False), ("", "D", True))
_HEIGHT_MM, _FIRST_PAGE_MM = 50.0, 40.0


@canvas.styled
def draw_evidence(drawn: EvidenceFigure, example: bool = True) -> Figure:
    """Draw the residual in held-out poses without and with the effect on one scale, and the effect's own picture.

    Parameters
    ----------
    drawn : the effect's. example : with the effect's own picture.

    Returns
    -------
    Figure; residuals in one unit, the covariate in its own unit (° for angles).
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, _HEIGHT_MM if example else _FIRST_PAGE_MM)
    if drawn.picture is None or not example:
        without, with_it = figure.subplots(1, 2, sharey=True, sharex=True)
    else:
        without, with_it, simple = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 0.8))
        with_it.sharey(without)
        with_it.sharex(without)
        draw_on(simple, drawn.picture)
        simple.set_title("effect (example)")
    value, covariate = covariate_axis(drawn)
    unit = residual_unit(drawn)
    finite = np.flatnonzero(np.isfinite(drawn.before) & np.isfinite(drawn.after) & np.isfinite(value))
    finite = finite[canvas.thinned(np.abs(drawn.before[finite]), MOST_POINTS)]
    for panel, residual, title in (
        (without, drawn.before, "without the effect"),
        (with_it, drawn.after, "with the effect"),
    ):
        _draw_points(panel, value, residual * unit.factor, drawn, finite)
        panel.set_title(f"{drawn.evidence.effect}: {title}" if len(drawn.evidence.effect) < 14 else title)
        panel.set_xlabel(covariate)
    without.set_ylabel(unit.in_brackets("residual along the effect"))
    with_it.tick_params(labelleft=False)
    extremes = np.concatenate([drawn.before[finite], drawn.after[finite]]) * unit.factor
    without.set_ylim(*canvas.padded_limits(np.concatenate([extremes, -extremes])))
    handles = {handle.get_label(): handle for handle in without.get_legend_handles_labels()[0]}
    canvas.share_legend(figure, list(handles.values()))
    return figure


def covariate_axis(drawn: EvidenceFigure) -> tuple[Floats, str]:
    """Return the covariate's values and its label; angles of joints in degrees."""
    if drawn.evidence.unit == "rad" and "angle" in drawn.evidence.driver:
        angle = JOINT_ANGLE.usual
        return angle.factor * drawn.value, angle.in_brackets(drawn.evidence.driver)
    if drawn.evidence.unit == "s" and np.nanmax(np.abs(drawn.value), initial=0.0) > 1000.0:
        return drawn.value / 60.0, f"{drawn.evidence.driver} [min]"
    unit = "" if drawn.evidence.unit in ("", "1") else f" [{drawn.evidence.unit}]"
    return drawn.value, drawn.evidence.driver + unit


def residual_unit(drawn: EvidenceFigure) -> ShownUnit:
    """Return the unit of the residuals."""
    return canvas.unit_of(of_measure(drawn.evidence.component), drawn.before)


def _draw_points(axes: Axes, value: Floats, residual: Floats, drawn: EvidenceFigure, known: Integers) -> None:
    axes.axhline(0.0, color=canvas.QUIET, linewidth=0.6)
    if np.nanmin(value) < 0.0 < np.nanmax(value):
        axes.axvline(0.0, color=canvas.QUIET, linewidth=0.5, zorder=0.5)
    cyclic = (drawn.branch != "").any()
    if drawn.path_run:
        other_rows = known[drawn.run[known] != drawn.path_run]
        axes.plot(
            value[other_rows],
            residual[other_rows],
            linestyle="none",
            marker=".",
            markersize=1.5,
            color=canvas.PALE,
            zorder=1,
        )
        known = np.flatnonzero((drawn.run == drawn.path_run) & np.isfinite(residual) & np.isfinite(value))
        axes.plot(value[known], residual[known], color=canvas.INK, linewidth=0.4, zorder=1.5)
    for branch, marker, filled in _BRANCHES:
        pick = known[drawn.branch[known] == branch]
        colour = canvas.BRANCH_COLOURS[branch]
        if pick.size:
            axes.plot(
                value[pick], residual[pick], linestyle="none", marker=marker, markersize=2.1, markeredgewidth=0.5,
                color=colour, markerfacecolor=colour if filled else "white",
                label=branch or ("unloaded" if cyclic else "load state"),
            )  # fmt: skip


@canvas.styled
def draw_errors_by_run(drawn: EvidenceFigure, noise: float | None) -> Figure:
    """Draw each run's error in held-out poses without and with the effect.

    Parameters
    ----------
    drawn : the effect's.
    noise : m or rad, rms of the noise; None where not known.

    Returns
    -------
    Figure; errors in one unit.
    """
    from stiffcal.report.figures.load_deformation import name_runs

    runs = drawn.evidence.by_run
    unit = residual_unit(drawn)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 38)
    axes = figure.subplots()
    at = np.arange(len(runs))
    before = np.array([run.before for run in runs]) * unit.factor
    after = np.array([run.after for run in runs]) * unit.factor
    axes.vlines(at, after, before, color=canvas.PALE, linewidth=2.0, zorder=1)
    axes.plot(
        at, before, linestyle="none", marker="s", markerfacecolor="white", color=canvas.ACCENT, markersize=4.5,
        label=f"without {drawn.evidence.effect}",
    )  # fmt: skip
    axes.plot(at, after, linestyle="none", marker="o", color=canvas.COLOURS[0], markersize=4.0, label="with the effect")
    if noise is not None:
        axes.axhline(
            noise * unit.factor, color=canvas.ACCENT, linestyle=(0, (5, 2)), linewidth=1.0, label="noise (rms)"
        )
    axes.set_ylim(0.0, float(max(before.max(), after.max())) * 1.12)
    axes.set_xlim(-0.7, len(at) - 0.3)
    axes.grid(visible=False, axis="x")
    of_what = {"motor_angle": "motors' error", "rotation": "rotation error"}.get(drawn.evidence.component, "error")
    axes.set_ylabel(unit.in_brackets(f"{of_what}, held-out"))
    name_runs(axes, [run.label for run in runs])
    canvas.share_legend(figure, axes.get_legend_handles_labels()[0])
    return figure
