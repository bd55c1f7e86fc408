"""Displacement along the one line in which a device presses and reads, run by run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.quantity import LENGTH, ShownUnit
from stiffcal.report.content import ReportStates
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PER_ROW, PER_SHEET = 3, 6
ROW_MM = 46.0
# m: a residual below it is not enlarged.
_LEAST_SCALE_M = 1e-6


@canvas.styled
def draw_along_lines(states: ReportStates, runs: list[int], names: list[str]) -> Figure:
    """Draw one panel per run, three in a row: displacement over force, and beneath it what the model leaves.

    Parameters
    ----------
    states : with ``along``.
    runs, names : the runs' numbers and what they are called.
    """
    rows = -(-len(runs) // PER_ROW)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, ROW_MM * rows + 6)
    panels = figure.subplots(2 * rows, PER_ROW, squeeze=False, gridspec_kw={"height_ratios": [2.2, 1.0] * rows})
    used = states.used & np.isin(states.run, runs)
    unit = canvas.unit_of(LENGTH, states.measured[used, :3])
    largest = unit.factor * _largest_left(states, runs)
    for place in range(rows * PER_ROW):
        above, below = (
            panels[2 * (place // PER_ROW), place % PER_ROW],
            panels[2 * (place // PER_ROW) + 1, place % PER_ROW],
        )
        if place >= len(runs):
            above.set_axis_off()
            below.set_axis_off()
            continue
        _draw_run(above, below, states, runs[place], names[place], unit)
        below.set_ylim(-1.1 * largest, 1.1 * largest)
        if place % PER_ROW == 0:
            above.set_ylabel(unit.in_brackets("displacement"))
            below.set_ylabel(unit.in_brackets("residual"))
        if place + PER_ROW >= len(runs):
            below.set_xlabel("force along the line of action [N]")
    canvas.share_legend(figure, list(panels[0, 0].get_legend_handles_labels()[0]))
    return figure


def _largest_left(states: ReportStates, runs: list[int]) -> float:
    """Return the largest residual of these runs, m: their lower panels have one scale."""
    inside = states.used & np.isin(states.run, runs)
    residual = np.linalg.norm((states.measured - states.predicted)[inside, :3], axis=1)
    return float(np.nanmax(residual, initial=_LEAST_SCALE_M))


def _draw_run(above: Axes, below: Axes, states: ReportStates, run: int, name: str, unit: ShownUnit) -> None:
    """Draw one run."""
    run_states = np.flatnonzero(states.used & (states.run == run))
    assert states.along is not None
    line = states.along[run_states]
    force, measured, predicted = (
        np.sum(line * values[run_states, :3], axis=1) for values in (states.force, states.measured, states.predicted)
    )
    for panel in (above, below):
        canvas.zero_lines(panel)
    is_unloading = states.branch[run_states] == "unloading"
    for going_back, text in ((False, "loading, measured"), (True, "unloading, measured")):
        these = is_unloading == going_back
        colour = canvas.COLOURS[1 if going_back else 0]
        face, size = ("none", 3.2) if going_back else (colour, 2.0)
        for panel, values, label in (
            (above, unit.factor * measured, text),
            (below, unit.factor * (measured - predicted), None),
        ):
            panel.plot(
                force[these], values[these], linestyle="none", marker="o", color=colour, markerfacecolor=face,
                markersize=size, markeredgewidth=0.5, label=label, zorder=3,
            )  # fmt: skip
    order = np.argsort(force, kind="stable")
    above.plot(force[order], unit.factor * predicted[order], color=canvas.MODEL, linewidth=0.7, label="model", zorder=2)
    above.set_title(f"{name}, along {_words(line[0])}")
    above.tick_params(labelbottom=False)


def _words(direction: np.ndarray) -> str:
    """Return a direction in words.

    Examples
    --------
    >>> _words(np.array([0.0, -1.0, 0.0])), _words(np.array([0.6, 0.8, 0.0]))
    ('−y', '(0.60, 0.80, 0.00)')
    """
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) > 0.999:
        return ("−" if direction[axis] < 0.0 else "") + "xyz"[axis]
    return "(" + ", ".join(f"{component:.2f}" for component in direction) + ")"
