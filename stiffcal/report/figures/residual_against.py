"""The residual against anything it might follow, each on its own scale."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.quantity import LENGTH
from stiffcal.report.content import ReportStates, ResidualCovariate
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_POINTS = 500


@canvas.styled
def draw_residual_against(
    states: ReportStates, covariates: Sequence[ResidualCovariate], noise: float | None = None
) -> Figure:
    """Draw the residual along x, y and z against each covariate: one row of panels per covariate.

    Parameters
    ----------
    states : the load states.
    covariates : what the residual might follow.
    noise : m, rms length of what instruments scatter; drawn as a band of ± two standard deviations per axis, the three
        axes taken alike (length / √3). None: no band.

    Returns
    -------
    Figure; residuals in one unit, base axes; covariates in their own units.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 9 + 25 * len(covariates) if len(covariates) > 1 else 62)
    panels = figure.subplots(len(covariates), 3, sharey=True, squeeze=False)
    used = np.flatnonzero(states.used)
    unnamed = "unloaded" if (states.branch[used] != "").any() else "load state"
    unit = canvas.unit_of(LENGTH, states.residual[used, :3])
    residual = states.residual * unit.factor
    used = used[canvas.thinned(np.linalg.norm(residual[used, :3], axis=1), MOST_POINTS)]
    limits = canvas.padded_limits(np.concatenate([residual[used, :3].ravel(), -residual[used, :3].ravel()]))
    for row, covariate in enumerate(covariates):
        for axis, letter in enumerate(canvas.AXES_NAMES):
            panel = panels[row, axis]
            panel.axhline(0.0, color=canvas.QUIET, linewidth=0.6)
            if noise is not None:
                # a gauge reads one component, a tracker three
                half = 2 * unit.factor * noise / (np.sqrt(3.0) if states.along is None else 1.0)
                panel.axhspan(-half, half, color=canvas.PALE, alpha=0.6, linewidth=0, zorder=0.3, label="± 2 × noise")
            for branch, marker, face in (("loading", "o", None), ("unloading", "s", "white"), ("", "D", None)):
                pick = used[(states.branch[used] == branch) & states.reads(axis)[used]]
                colour = canvas.BRANCH_COLOURS[branch]
                if pick.size:
                    panel.plot(
                        covariate.values[pick], residual[pick, axis], linestyle="none", marker=marker, markersize=2.0,
                        markeredgewidth=0.5, color=colour, markerfacecolor=face or colour, label=branch or unnamed,
                    )  # fmt: skip
            panel.set_ylim(*limits)
            panel.set_xlabel(f"{covariate.name} [{covariate.unit}]")
            panel.set_ylabel(unit.in_brackets(f"residual {letter}"))
    canvas.share_legend(figure, panels[0, 0].get_legend_handles_labels()[0])
    return figure
