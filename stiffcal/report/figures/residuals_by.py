"""Where the model fails: residuals by run, direction of force, size of load, branch, joint angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from stiffcal.quantity import ShownUnit, Units, of_measure
from stiffcal.report import wording
from stiffcal.report.figures import canvas
from stiffcal.report.figures.load_deformation import name_runs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiffcal.measurements.rms import Rms
    from stiffcal.validation.results import ErrorSlice

Slices: TypeAlias = "Sequence[ErrorSlice]"
_COMPONENTS = ("translation", "rotation", "length")


def _draw_bars(axes: Axes, parts: Slices, component: str, noise: float | None, unit: ShownUnit) -> None:
    """Draw rms as bars, the largest residual as a mark, the noise as a line."""
    at = np.arange(len(parts))
    rms, largest = (
        np.array([wording.part(measure, component) or np.nan for measure in measures]) * unit.factor
        for measures in ([part.rms for part in parts], [part.max for part in parts])
    )
    axes.bar(
        at, rms, width=0.62, color="#c6dbef", edgecolor=canvas.COLOURS[0], hatch="////", linewidth=0.7, label="rms"
    )
    if any(part.n > 1 for part in parts):
        axes.plot(
            at, largest, linestyle="none", marker="_", markersize=6, color=canvas.INK, label="largest single residual"
        )
    if noise is not None:
        axes.axhline(
            noise * unit.factor, color=canvas.ACCENT, linestyle=(0, (5, 2)), linewidth=1.0, label="noise (rms)"
        )
    axes.set_ylim(0, canvas.padded_limits(np.concatenate([rms, largest]))[1])
    axes.set_xlim(-0.7, len(parts) - 0.3)
    axes.grid(visible=False, axis="x")
    words = {"translation": "residual", "length": "rods’ residual"}.get(component, f"{component} residual")
    axes.set_ylabel(unit.in_brackets(words))


def _components(parts: Slices) -> list[str]:
    return [key for key in _COMPONENTS if any(wording.part(part.rms, key) is not None for part in parts)] or [
        "translation"
    ]


def _row_height(components: Sequence[str]) -> float:
    """Return the height of all rows of panels, mm: two pictures of three rows share a page."""
    return len(components) * (32.0 if len(components) < 3 else 25.0)


@canvas.styled
def draw_residuals_by_run(parts: Slices, noise: Rms | None = None) -> Figure:
    """Draw the residual of each run.

    Parameters
    ----------
    parts : the errors run by run.
    noise : what the instruments scatter; None where it cannot be judged.

    Returns
    -------
    Figure; one unit a quantity.
    """
    components, units = _components(parts), Units.of_errors(part.max for part in parts)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 12 + _row_height(components))
    panels = figure.subplots(len(components), 1, sharex=True, squeeze=False)[:, 0]
    for panel, component in zip(panels, components, strict=True):
        _draw_bars(panel, parts, component, wording.part(noise, component), units.of(of_measure(component)))
    name_runs(panels[-1], [part.label for part in parts])
    canvas.share_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure


@canvas.styled
def draw_residuals_by(groups: Sequence[tuple[str, Slices]], noise: Rms | None = None) -> Figure:
    """Draw the residual by several ways of sorting the states, one column of panels each.

    Parameters
    ----------
    groups : (what the states are sorted by, in words such as "direction of force"; the errors in each part).
    noise : what the instruments scatter; None where it cannot be judged.

    Returns
    -------
    Figure; one unit a quantity, one scale for all columns.
    """
    every = [part for _, parts in groups for part in parts]
    components, units = _components(every), Units.of_errors(part.max for part in every)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 22 + _row_height(components))
    widths = [max(2.0, len(parts)) for _, parts in groups]
    panels = figure.subplots(
        len(components), len(groups), sharex="col", sharey="row", squeeze=False, width_ratios=widths
    )  # fmt: skip
    for row, component in enumerate(components):
        top = 0.0
        for column, (title, parts) in enumerate(groups):
            panel = panels[row, column]
            _draw_bars(panel, parts, component, wording.part(noise, component), units.of(of_measure(component)))
            top = max(top, panel.get_ylim()[1])
            panel.set_ylim(0, top)
            if column:
                panel.set_ylabel("")
            if row == len(components) - 1:
                labels = [part.label for part in parts]
                panel.set_xticks(range(len(labels)), labels)
                panel.tick_params(axis="x", labelrotation=90.0 if max(map(len, labels), default=0) > 4 else 0.0)
                panel.set_xlabel(title)
    canvas.share_legend(figure, panels[0, 0].get_legend_handles_labels()[0])
    return figure
