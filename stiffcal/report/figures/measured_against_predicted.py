"""Measured against predicted deflection: on the diagonal the model is right."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.quantity import of_component
from stiffcal.report.content import ReportStates
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 1500


def _draw_panel(axes: Axes, states: ReportStates, component: int, scale: float) -> None:
    used = np.flatnonzero(states.used & states.reads(component))
    used = used[canvas.thinned(np.linalg.norm(states.residual[used, :3], axis=1), MOST_POINTS)]
    measured, predicted = states.measured[:, component] * scale, states.best_prediction[:, component] * scale
    unnamed = "unloaded" if (states.branch[used] != "").any() else "load state"
    limits = canvas.padded_limits(np.concatenate([measured[used], predicted[used]]))
    axes.plot(limits, limits, color=canvas.QUIET, linewidth=0.8, linestyle=(0, (6, 2)), zorder=1)
    for branch, marker, size in (("loading", "o", 1.8), ("unloading", "s", 3.4), ("", "D", 2.0)):
        pick = used[states.branch[used] == branch]
        if not pick.size:
            continue
        colour = canvas.BRANCH_COLOURS[branch]
        face = "none" if branch == "unloading" else colour
        axes.plot(
            predicted[pick], measured[pick], linestyle="none", marker=marker, markersize=size, markeredgewidth=0.4,
            color=colour, markerfacecolor=face, label=branch or unnamed, zorder=3,
        )  # fmt: skip
    axes.set_xlim(*limits)
    axes.set_ylim(*limits)
    axes.set_box_aspect(1.0)


@canvas.styled
def draw_measured_against_predicted(states: ReportStates) -> Figure:
    """Draw measured against predicted deflection, one panel per component.

    Parameters
    ----------
    states : the load states; predictions for held-out poses are used where there are any.

    Returns
    -------
    Figure; deflections and rotations in a unit each, base axes.
    """
    rows = 2 if states.has_rotation else 1
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 9 + 44 * rows)
    panels = figure.subplots(rows, 3, squeeze=False)
    for row in range(rows):
        unit = canvas.unit_of(of_component(3 * row), states.measured[states.used, 3 * row : 3 * row + 3])
        for axis, letter in enumerate(canvas.AXES_NAMES):
            panel = panels[row, axis]
            _draw_panel(panel, states, 3 * row + axis, unit.factor)
            name = f"{'R' if row else 'D'}{letter}"
            panel.set_xlabel(unit.in_brackets(f"predicted {name}"))
            panel.set_ylabel(unit.in_brackets(f"measured {name}"))
    canvas.share_legend(figure, panels[0, 0].get_legend_handles_labels()[0])
    return figure
