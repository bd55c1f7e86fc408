"""Links with rods: rods over force (000, Fig. 5), the link's end (Fig. 6), the tool with and without it (Fig. 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quantity import LENGTH, of_component
from stiffcal.report import wording
from stiffcal.report.figures import canvas
from stiffcal.report.link_pictures import BentLink, LinkPicture, LinkRun
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


ROW_MM = 46.0
COMPONENTS = ("u1", "u2", "u3", "φ1", "φ2", "φ3")
# A bent link is drawn with its largest displacement as long as this share of the link.
BENT_SHARE = 0.12
# Space for the rods' names next to the link, over its length, and height of a name over that of a panel.
NAMES_SHARE, NAME_HEIGHT = 0.24, 0.13


@canvas.styled
def draw_rods(picture: LinkPicture) -> Figure:
    """Draw every rod's change over the force, run by run: marks as read, lines the model."""
    figure, panels = _grid(len(picture.large_runs))
    unit = canvas.unit_of(LENGTH, *(picture.runs[number].lengths for number in picture.large_runs))
    for panel, number in zip(panels, picture.large_runs, strict=False):
        run = picture.runs[number]
        for rod, name in enumerate(picture.rods):
            label = f"{name}, {wording.length(picture.rod_lengths[rod], digits=4)}"
            colour = canvas.COLOURS[rod % len(canvas.COLOURS)]
            _marks(
                panel, run, unit.factor * run.lengths[:, rod], colour, canvas.MARKERS[rod % len(canvas.MARKERS)], label
            )
            if run.modelled is not None:
                _line(panel, run.force, unit.factor * run.modelled[:, rod], colour, "-", None)
        _dress(panel, run, unit.in_brackets("change of length"))
    canvas.share_legend(figure, _handles(panels))
    return figure


@canvas.styled
def draw_end(picture: LinkPicture, number: int) -> Figure:
    """Draw the six displacements of the link's end over the force: marks from the rods, lines by the compliance."""
    run = picture.runs[number]
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 78)
    for panel, first in zip(figure.subplots(1, 2), (0, 3), strict=True):
        unit = canvas.unit_of(of_component(first), run.end[:, first : first + 3])
        for k in range(first, first + 3):
            if not np.isfinite(run.end[:, k]).any():
                continue
            colour = canvas.COLOURS[k - first]
            label = f"{COMPONENTS[k]} ± {wording.in_unit(NORMAL_95 * float(run.end_std[k]), unit, 2)}"
            _marks(panel, run, unit.factor * run.end[:, k], colour, canvas.MARKERS[k - first], label)
            _line(panel, run.force, unit.factor * run.by_wrench[:, k], colour, "-", None)
        _dress(panel, run, unit.in_brackets(f"{'displacement' if first == 0 else 'turn'} of the link's end"))
        panel.legend(loc="best")
    return figure


@canvas.styled
def draw_tool(picture: LinkPicture) -> Figure:
    """Draw the tool's displacement along the force: measured, by the model with the link and with the link rigid."""
    chosen = [number for number in picture.large_runs if picture.runs[number].tool is not None]
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 48.0 * ((len(chosen) + 1) // 2))
    rows = (len(chosen) + 1) // 2
    panels = figure.subplots(2 * rows, 2, squeeze=False, gridspec_kw={"height_ratios": [2.0, 1.0] * rows})
    for place, number in enumerate(chosen):
        run = picture.runs[number]
        above, below = panels[2 * (place // 2), place % 2], panels[2 * (place // 2) + 1, place % 2]
        _draw_tool_run(above, below, run)
    for place in range(len(chosen), 2 * rows):
        for row in (0, 1):
            panels[2 * (place // 2) + row, place % 2].set_axis_off()
    canvas.share_legend(figure, _handles([panels[0, 0]]))
    return figure


def _draw_tool_run(above: Axes, below: Axes, run: LinkRun) -> None:
    """Draw one run: displacement above, what the model leaves of it below."""
    assert run.tool is not None
    assert run.with_link is not None
    unit = canvas.unit_of(LENGTH, run.tool)
    canvas.zero_lines(above)
    _marks(above, run, unit.factor * run.tool, canvas.COLOURS[0], "o", "measured")
    _line(above, run.force, unit.factor * run.with_link, canvas.MODEL, "-", "model with the link")
    if run.without_link is not None:
        _line(
            above, run.force, unit.factor * run.without_link, canvas.COLOURS[1], (0, (4, 2)), "same model, link rigid"
        )
    above.set_title(f"{run.name}, along {run.along}")
    above.set_ylabel(unit.in_brackets("tool"))
    above.tick_params(labelbottom=False)
    canvas.zero_lines(below)
    _marks(below, run, unit.factor * (run.tool - run.with_link), canvas.COLOURS[0], "o", None)
    if run.without_link is not None:
        _line(below, run.force, unit.factor * (run.with_link - run.without_link), canvas.COLOURS[1], (0, (4, 2)), None)
    below.set_ylabel(unit.in_brackets("residual"))
    below.set_xlabel(f"force along {run.along} [N]")


@canvas.styled
def draw_bent(picture: LinkPicture) -> Figure:
    """Draw the link bent, magnified, in its two planes, with its rods: longer red, shorter blue."""
    bent = picture.bent_link
    size = float(np.abs(bent.displacement).max())
    factor = _round_down(BENT_SHARE * float(bent.x1[-1]) / size) if size > 0.0 else 1.0
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 84)
    for panel, across in zip(figure.subplots(2, 1, sharex=True), (1, 2), strict=True):
        _draw_bent_plane(panel, picture, across, factor)
    times = f"{factor:,.0f}".replace(",", " ")
    panel.set_xlabel(f"x1, along the link from its clamped end [m]; displacements drawn {times} times")
    canvas.share_legend(figure, _handles([panel]))
    return figure


def _draw_bent_plane(panel: Axes, picture: LinkPicture, across: int, factor: float) -> None:
    """Draw the plane of x1 and one axis across."""
    bent: BentLink = picture.bent_link
    panel.plot(bent.x1, np.zeros_like(bent.x1), color=canvas.QUIET, linewidth=0.8, label="axis at rest")
    drawn_displacement = bent.x1 + factor * bent.displacement[:, 0]
    panel.plot(
        drawn_displacement,
        factor * bent.displacement[:, across],
        color=canvas.MODEL,
        linewidth=1.6,
        label="axis, deflected",
    )
    scale, unit = float(np.abs(bent.change).max()) or 1.0, canvas.unit_of(LENGTH, bent.change)
    texts: list[tuple[float, float, str, str]] = []
    for rod, name in enumerate(picture.rods):
        colour = canvas.COLOURS[1] if bent.change[rod] > 0.0 else canvas.COLOURS[5]
        word = "rod under extension" if bent.change[rod] > 0.0 else "rod under compression"
        x, y = (bent.start[rod, 0], bent.end[rod, 0]), (bent.start[rod, across], bent.end[rod, across])
        width = 0.6 + 2.4 * abs(float(bent.change[rod])) / scale
        panel.plot(x, y, color=colour, linewidth=width, label=word, solid_capstyle="butt", zorder=2)
        sign = "+" if bent.change[rod] > 0.0 else ""
        text = f"{name} {sign}{wording.in_unit(float(bent.change[rod]), unit)}"
        texts.append((y[0], max(x), text, colour))
    panel.set_ylabel(f"x{across + 1} [m]")
    panel.margins(x=0.03, y=0.12)
    _name_rods(panel, texts, float(bent.x1[-1]))


def _name_rods(panel: Axes, texts: list[tuple[float, float, str, str]], length: float) -> None:
    """Write what rods are called next to the link, one above the other, with a thin line to where each ends.

    Parameters
    ----------
    texts : height and end of each rod, its name, its colour. length : of the link.
    """
    low, high = panel.get_ylim()
    gap = NAME_HEIGHT * (high - low)
    texts = sorted(texts)
    places = np.array([height for height, *_ in texts])
    for k in range(1, len(places)):
        places[k] = max(places[k], places[k - 1] + gap)
    # as many go up as down
    places += np.mean([height for height, *_ in texts]) - places.mean()
    for (height, end, text, colour), place in zip(texts, places.tolist(), strict=True):
        panel.plot((end, 1.04 * length, 1.08 * length), (height, place, place), color=colour, linewidth=0.4, zorder=1)
        panel.annotate(text, (1.09 * length, place), fontsize=5.5, color=colour, va="center")
    panel.set_ylim(min(low, places[0] - gap), max(high, places[-1] + gap))
    panel.set_xlim(-0.03 * length, (1.0 + NAMES_SHARE) * length)


def _grid(count: int) -> tuple[Figure, list[Axes]]:
    """Return a figure of panels, two in a row."""
    rows = (count + 1) // 2
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, ROW_MM * rows + 6)
    panels = list(figure.subplots(rows, 2, squeeze=False).flat)
    for panel in panels[count:]:
        panel.set_axis_off()
    return figure, panels[:count]


def _marks(panel: Axes, run: LinkRun, values: Floats, colour: str, marker: str, label: str | None) -> None:
    """Draw readings, hollow where the load went back."""
    for unloading in (False, True):
        of_branch = run.unloading == unloading
        panel.plot(
            run.force[of_branch], values[of_branch], linestyle="none", marker=marker, color=colour, markersize=2.6,
            markerfacecolor="none" if unloading else colour, markeredgewidth=0.5, zorder=3,
            label=None if unloading else label,
        )  # fmt: skip


def _line(panel: Axes, force: Floats, values: Floats, colour: str, style: object, label: str | None) -> None:
    """Draw a model over the force, in order of the force."""
    order = np.argsort(force, kind="stable")
    panel.plot(force[order], values[order], color=colour, linestyle=style, linewidth=0.8, label=label, zorder=2)


def _dress(panel: Axes, run: LinkRun, words: str) -> None:
    canvas.zero_lines(panel)
    panel.set_title(f"{run.name}, load along {run.along}")
    panel.set_xlabel(f"force along {run.along} [N]")
    panel.set_ylabel(words)


def _handles(panels: list[Axes]) -> list[object]:
    handle_of_label: dict[str, object] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handle_of_label.setdefault(str(label), handle)
    return list(handle_of_label.values())


def _round_down(value: float) -> float:
    """Return the value with one digit, never larger."""
    decade = 10.0 ** np.floor(np.log10(value))
    return float(np.floor(value / decade) * decade)
