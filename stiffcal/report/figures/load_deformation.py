"""Deflection against force, loading and unloading apart, the model over them (002, Fig. 4b)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.quantity import LENGTH, ShownUnit
from stiffcal.report.content import ReportStates
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROWS_PER_SHEET = 5


def direction_styles(states: ReportStates, chosen: Integers) -> dict[str, tuple[str, str]]:
    """Give each direction of load a colour and a marker, the same in all pictures of these states.

    Opposite directions share the colour.

    Parameters
    ----------
    states : the load states.
    chosen : indices of the states that will be drawn.

    Returns
    -------
    label to (colour, marker), of the directions of the chosen states.
    """
    used = np.flatnonzero(states.used)
    labels = sorted({str(label) for label in states.direction[used] if label})
    units = {label: _unit_forces(states, used, label) for label in labels}
    styles: dict[str, tuple[str, str]] = {}
    n_colours = 0
    for number, label in enumerate(labels):
        partner = next((known_label for known_label in styles if _opposite(units[label], units[known_label])), None)
        if partner is None:
            colour = canvas.COLOURS[n_colours % len(canvas.COLOURS)]
            n_colours += 1
        else:
            colour = styles[partner][0]
        styles[label] = (colour, canvas.MARKERS[number % len(canvas.MARKERS)])
    drawn = set(states.direction[chosen].tolist())
    return {label: style for label, style in styles.items() if label in drawn}


def _unit_forces(states: ReportStates, chosen: Integers, label: str) -> dict[int, Floats]:
    """Mean direction of a label's force in each run; labels may mean another direction in another run."""
    units: dict[int, Floats] = {}
    for run in np.unique(states.run[chosen]):
        total = states.force[chosen[(states.direction[chosen] == label) & (states.run[chosen] == run)]].sum(axis=0)
        if np.linalg.norm(total) > 0:
            units[int(run)] = np.asarray(total / np.linalg.norm(total), dtype=np.float64)
    return units


def _opposite(first: dict[int, Floats], second: dict[int, Floats]) -> bool:
    shared = first.keys() & second.keys()
    return bool(shared) and all(float(first[run] @ second[run]) < -0.9 for run in shared)


def branch_stretches(states: ReportStates, chosen: Integers) -> list[tuple[str, Integers]]:
    """Cut the states of one run, in order, into stretches of one direction and branch.

    Each stretch starts with the state before it, so that its line begins where the load turned.

    Returns
    -------
    (branch, indices) of each stretch.
    """
    stretches: list[tuple[str, list[int]]] = []
    previous: int | None = None
    last = ("", "")
    for index in chosen:
        key = (str(states.direction[index]), str(states.branch[index]))
        if not key[0]:
            previous, last = int(index), ("", "")
            continue
        if key != last or not stretches:
            stretches.append((key[1], [] if previous is None else [previous]))
            last = key
        stretches[-1][1].append(int(index))
        previous = int(index)
    return [(branch, np.array(indices, dtype=np.int64)) for branch, indices in stretches]


def states_of_run(states: ReportStates, run: int) -> Integers:
    """Indices of a run's states that were not set aside, in order, the reference among them."""
    keep = states.run == run
    if states.set_aside is not None:
        keep = keep & (states.set_aside == "")
    return np.flatnonzero(keep)


def _draw_panel(
    axes: Axes, states: ReportStates, run: int, axis: int, styles: dict[str, tuple[str, str]], unit: ShownUnit
) -> None:
    """Draw the deflection along one base axis against the force along it [N]."""
    chosen = states_of_run(states, run)
    force, (measured, predicted) = (
        states.force[:, axis],
        (unit.factor * values[:, axis] for values in (states.measured, states.predicted)),
    )
    canvas.zero_lines(axes)
    for branch, style in (("loading", "-"), ("unloading", (0, (4, 2)))):
        path = _joined([indices for name, indices in branch_stretches(states, chosen) if (name or "loading") == branch])
        # A negative index marks the gap between two stretches; NaN breaks the line there.
        x, y = (np.where(path < 0, np.nan, values[path]) for values in (force, predicted))
        axes.plot(x, y, color=canvas.MODEL, linewidth=0.7, linestyle=style, zorder=2)
    _draw_markers(axes, states, chosen, styles, (force, measured))
    unloaded = np.flatnonzero(states.used & (states.run == run) & (states.direction == ""))
    if unloaded.size:
        axes.plot(
            force[unloaded], measured[unloaded], linestyle="none", marker="+", color=canvas.QUIET, markersize=3,
            zorder=2.5,
        )  # fmt: skip
    if states.set_aside is not None and (states.set_aside[states.run == run] != "").any():
        set_aside = np.flatnonzero((states.run == run) & (states.set_aside != ""))
        axes.plot(
            force[set_aside],
            measured[set_aside],
            linestyle="none",
            marker="x",
            color=canvas.INK,
            markersize=4,
            zorder=4,
        )


def _joined(stretches: list[Integers]) -> Integers:
    """Put stretches into one row of indices, -1 between them."""
    gap = np.array([-1], dtype=np.int64)
    return np.concatenate([piece for stretch in stretches for piece in (stretch, gap)]) if stretches else gap


def _draw_markers(
    axes: Axes, states: ReportStates, chosen: Integers, styles: dict[str, tuple[str, str]], xy: tuple[Floats, Floats]
) -> None:
    """Draw points by direction: filled while loading, larger and hollow while unloading."""
    for label, (colour, marker) in styles.items():
        for branch in dict.fromkeys(states.branch[chosen].tolist()):
            pick = chosen[(states.direction[chosen] == label) & (states.branch[chosen] == branch)]
            if not pick.size:
                continue
            face, size = ("none", 4.2) if branch == "unloading" else (colour, 2.4)
            axes.plot(
                xy[0][pick], xy[1][pick], linestyle="none", marker=marker, color=colour, markerfacecolor=face,
                markersize=size, markeredgewidth=0.6, zorder=3,
            )  # fmt: skip


def _has_aside(states: ReportStates, runs: list[int]) -> bool:
    return states.set_aside is not None and bool(((states.set_aside != "") & np.isin(states.run, runs)).any())


def _legend_handles(states: ReportStates, runs: list[int], styles: dict[str, tuple[str, str]]) -> list[Any]:
    from matplotlib.lines import Line2D

    handles: list[Any] = [
        Line2D([], [], linestyle="none", marker=marker, color=colour, label=label)
        for label, (colour, marker) in styles.items()
    ]
    branches: set[str] = set(states.branch[np.isin(states.run, runs)].tolist())
    if "unloading" in branches:
        handles.append(
            Line2D([], [], linestyle="none", marker="o", markersize=2.4, color=canvas.INK, label="loading, measured")
        )
        handles.append(
            Line2D(
                [],
                [],
                linestyle="none",
                marker="o",
                markersize=4.2,
                color=canvas.INK,
                markerfacecolor="none",
                label="unloading, measured",
            )
        )
    handles.append(Line2D([], [], color=canvas.MODEL, label="model" + (", loading" if "unloading" in branches else "")))
    if "unloading" in branches:
        handles.append(Line2D([], [], color=canvas.MODEL, linestyle=(0, (4, 2)), label="model, unloading"))
    if (states.used & np.isin(states.run, runs) & (states.direction == "")).any():
        handles.append(Line2D([], [], linestyle="none", marker="+", color=canvas.QUIET, label="unloaded"))
    if _has_aside(states, runs):
        handles.append(Line2D([], [], linestyle="none", marker="x", color=canvas.INK, label="set aside"))
    return handles


@canvas.styled
def draw_load_deformation(states: ReportStates, run: int, name: str = "") -> Figure:
    """Draw one run: deflection against force along x, y and z, and under it what the model leaves.

    Parameters
    ----------
    states : the load states.
    run : index of the run.
    name : the run's name, for the titles; "" where a caption names it.

    Returns
    -------
    Figure; forces in N, deflections and residuals in one unit, base axes.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 80)
    panels = figure.subplots(2, 3, sharex="col", sharey="row", height_ratios=(2.6, 1.0))
    chosen = states_of_run(states, run)
    styles = direction_styles(states, chosen)
    unit = canvas.unit_of(LENGTH, states.measured[chosen, :3])
    residual = (states.measured - states.predicted) * unit.factor
    for axis, letter in enumerate(canvas.AXES_NAMES):
        upper, lower = panels[0, axis], panels[1, axis]
        _draw_panel(upper, states, run, axis, styles, unit)
        canvas.zero_lines(lower)
        _draw_markers(lower, states, chosen, styles, (states.force[:, axis], residual[:, axis]))
        upper.set_title(f"{name}, along {letter}" if name else f"along {letter}")
        upper.set_ylabel(unit.in_brackets(f"deflection D{letter}"))
        lower.set_ylabel(unit.in_brackets("residual"))
        lower.set_xlabel(f"force F{letter} [N]")
    canvas.share_legend(figure, _legend_handles(states, [run], styles))
    return figure


@canvas.styled
def draw_load_deformation_sheet(states: ReportStates, runs: list[int], names: list[str]) -> Figure:
    """Draw several runs as small multiples: one row each, x, y and z side by side, common scales.

    Parameters
    ----------
    states : the load states.
    runs : indices of the runs, at most `ROWS_PER_SHEET` look well on a page.
    names : the runs' names, in the same order.

    Returns
    -------
    Figure; forces in N, deflections in one unit, base axes.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 15 + 18.0 * len(runs))
    panels = figure.subplots(len(runs), 3, sharex="col", sharey=True, squeeze=False)
    every = np.concatenate([states_of_run(states, run) for run in runs])
    many = direction_styles(states, every)
    unit = canvas.unit_of(LENGTH, states.measured[every, :3])
    for row, (run, name) in enumerate(zip(runs, names, strict=True)):
        styles = {label: many[label] for label in many if (states.direction[states_of_run(states, run)] == label).any()}
        for axis, letter in enumerate(canvas.AXES_NAMES):
            panel = panels[row, axis]
            _draw_panel(panel, states, run, axis, styles, unit)
            panel.set_title(f"{name}, {letter}", fontsize=6.5, pad=2)
            panel.set_ylabel(unit.in_brackets(f"D{letter}"))
            if row == len(runs) - 1:
                panel.set_xlabel(f"force F{letter} [N]")
    canvas.share_legend(figure, _legend_handles(states, runs, many))
    return figure


@canvas.styled
def draw_deflection_by_run(states: ReportStates, names: list[str], runs: list[int]) -> Figure:
    """Draw single-state runs: measured and predicted deflection of each, in x, y and z.

    Parameters
    ----------
    states : the load states; only those used are drawn.
    names : names of all runs, by index.
    runs : indices of the runs to draw.

    Returns
    -------
    Figure; deflections in one unit, base axes; runs along the abscissa.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 80)
    panels = figure.subplots(3, 1, sharex=True)
    used = np.flatnonzero(states.used & np.isin(states.run, runs))
    unit = canvas.unit_of(LENGTH, states.measured[used, :3])
    at = np.array([runs.index(run) for run in states.run[used]], dtype=np.float64)
    for axis, (letter, panel) in enumerate(zip(canvas.AXES_NAMES, panels, strict=True)):
        measured, predicted = (unit.factor * of[used, axis] for of in (states.measured, states.best_prediction))
        panel.axhline(0.0, color=canvas.QUIET, linewidth=0.5)
        panel.vlines(at, measured, predicted, color=canvas.QUIET, linewidth=1.0)
        panel.plot(
            at, predicted, linestyle="none", marker="D", color=canvas.INK, markerfacecolor="white", label="predicted"
        )
        # on top, and smaller: where both are nearly one, both are visible
        panel.plot(
            at, measured, linestyle="none", marker="o", markersize=2.0, color=canvas.COLOURS[0], label="measured"
        )
        panel.set_ylabel(unit.in_brackets(f"D{letter}"))
        panel.set_xlim(-0.8, len(runs) - 0.2)
    name_runs(panels[-1], [names[run] for run in runs])
    canvas.share_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def name_runs(axes: Axes, names: list[str]) -> None:
    """Write run names under the abscissa, every one while they fit, else every second, fifth, ...

    Words with which all of them begin, as "poses row" of rows of a table, stand once, in the axis' label.
    """
    begins = {name.rpartition(" ")[0] for name in names}
    begin = begins.pop() if len(begins) == 1 else ""
    names = [name.removeprefix(begin).strip() for name in names]
    step = next((step for step in (1, 2, 5, 10, 20, 50) if len(names) / step <= 50), 100)
    places = list(range(0, len(names), step))
    axes.set_xticks(places, [names[i] for i in places])
    axes.tick_params(axis="x", labelrotation=90.0 if len(names) > 12 else 0.0)
    axes.set_xlabel(begin or "run")
