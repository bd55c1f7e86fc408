"""Quantities over the workspace: coloured where the robot reaches, with reach and joint limits (003, Fig. 4, 5)."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quantity import ANGLE, LENGTH, LINEAR_STIFFNESS
from stiffcal.report import wording
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiffcal.compensation.map_result import MapResult

# Readable in grey and to the colour-blind: dark to light in one even run.
_MAP = "viridis"
_LIMIT_DEG = 5.0
_MOST_ACROSS = 3
_MOST_LETTERS = 30  # of a label below a panel


@dataclass(frozen=True)
class _Quantity:
    """What a panel shows."""

    name: str
    unit: str
    values: Floats
    """(S, R, C), NaN where not reached."""


def _quantities(result: MapResult) -> list[_Quantity]:
    workspace, task, shape = result.found, result.task, result.grid.shape
    quantities = []
    if task.wrench.any():
        for name, size, quantity in (
            ("position error", workspace.position_error, LENGTH),
            ("orientation error", workspace.orientation_error, ANGLE),
        ):
            unit = canvas.unit_of(quantity, size)
            quantities.append(_Quantity(name, unit.name, unit.factor * size.reshape(shape)))
    if task.direction is not None:
        text = ", ".join(wording.significant(value) for value in task.direction)
        unit = canvas.unit_of(LINEAR_STIFFNESS, workspace.stiffness)
        quantities.append(
            _Quantity(f"stiffness along ({text})", unit.name, unit.factor * workspace.stiffness.reshape(shape))
        )
    return quantities


def _title(result: MapResult) -> str:
    wrench = result.task.wrench
    load = "no load"
    if wrench.any():
        force, moment = (
            ", ".join(wording.significant(value, 4) for value in components) for components in (wrench[:3], wrench[3:])
        )
        load = f"load ({force}) N" + (f", ({moment}) N·m" if wrench[3:].any() else "")
    kept = "orientation as in the pose drawn"
    if result.task.rotation is None:
        kept = "orientation free, arm near the pose drawn"
    return f"{result.grid.campaign}: {load}; {kept}"


@canvas.styled
def draw_workspace(result: MapResult) -> Figure:
    """Draw each quantity over a plane; of several planes one row each, every quantity on one scale.

    Returns
    -------
    Figure; places in m.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    grid, quantities = result.grid, _quantities(result)
    count = len(quantities)
    panels = [(level, quantity) for level in range(len(grid.levels)) for quantity in quantities]
    columns = min(len(panels) if count == 1 else count, _MOST_ACROSS)
    rows = -(-len(panels) // columns)
    ratio = float(np.ptp(grid.up) / np.ptp(grid.across))
    width = canvas.PAGE_WIDTH_MM / columns
    figure = canvas.new_figure(
        canvas.PAGE_WIDTH_MM, rows * (0.84 * width * min(max(ratio, 0.5), 1.6) + 24) + 15, constrained=True
    )
    drawn = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (level, quantity) in zip(drawn, panels, strict=False):
        _draw_panel(figure, axes, result, level, quantity)
    for axes in drawn[len(panels) :]:
        axes.set_axis_off()
    figure.suptitle(_title(result), fontsize=7.0, x=0.01, ha="left")
    handles = [
        Line2D(
            [], [], color=canvas.INK, linewidth=1.2, marker="o", markersize=2.4, markerfacecolor="white", label="arm"
        ),
        Patch(facecolor=canvas.PALE, label="out of reach"),
        Patch(facecolor="#f4f4f4", edgecolor=canvas.QUIET, hatch="xxxx", label="only beyond joint limits"),
    ]
    if (np.degrees(result.found.margin) < _LIMIT_DEG).any():
        label = f"{_LIMIT_DEG:g}° from a joint limit"
        handles.append(Line2D([], [], color=canvas.ACCENT, linestyle="--", linewidth=0.9, label=label))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _draw_panel(figure: Figure, axes: Axes, result: MapResult, level: int, quantity: _Quantity) -> None:
    from matplotlib.ticker import MaxNLocator

    grid, values = result.grid, quantity.values
    status = result.found.status.reshape(grid.shape)[level]
    axes.grid(visible=False)
    axes.set_facecolor(canvas.PALE)
    limits = np.where(status == 1, 1.0, np.nan)
    if np.isfinite(limits).any():
        axes.contourf(
            grid.across, grid.up, np.where(status == 1, 1.0, 0.0), levels=[0.5, 1.5], colors=["#f4f4f4"],
            hatches=["xxxx"], zorder=1,
        )  # fmt: skip
    low, high = _scale(values)
    mesh = axes.pcolormesh(
        grid.across, grid.up, np.ma.masked_invalid(values[level]), cmap=_MAP, shading="nearest",
        vmin=low, vmax=high, rasterized=True, zorder=2,
    )  # fmt: skip
    margin = np.degrees(result.found.margin).reshape(grid.shape)[level]
    if (margin < _LIMIT_DEG).any() and (margin > _LIMIT_DEG).any():
        axes.contour(
            grid.across, grid.up, np.ma.masked_invalid(margin), levels=[_LIMIT_DEG], colors=[canvas.ACCENT],
            linewidths=0.9, linestyles="--", zorder=3,
        )  # fmt: skip
    axes.plot(
        grid.arm[:, 0], grid.arm[:, 1], color=canvas.INK, linewidth=1.2, marker="o", markersize=2.4,
        markerfacecolor="white", zorder=4,
    )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_xlim(grid.across[0], grid.across[-1])
    axes.set_ylim(grid.up[0], grid.up[-1])
    across, up, through = ("xyz"[axis] for axis in grid.axes)
    axes.set_xlabel(f"{across} [m]")
    axes.set_ylabel(f"{up} [m]")
    axes.set_title(f"{through} = {round(grid.levels[level], 3):g} m")
    bar = figure.colorbar(mesh, ax=axes, location="bottom", shrink=0.9, aspect=28, extend=_beyond(values, low, high))
    bar.set_label(fill(f"{quantity.name} [{quantity.unit}]", _MOST_LETTERS))
    bar.locator = MaxNLocator(5)
    bar.update_ticks()
    bar.outline.set_linewidth(0.4)


def _scale(values: Floats) -> tuple[float, float]:
    """Return the ends of the colours: all but the outermost hundredth, which singular poses would stretch it by."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return 0.0, 1.0
    low, high = (float(np.quantile(finite, share)) for share in (0.01, 0.99))
    if low > 0.0 and low < 0.3 * high:
        low = 0.0
    return low, high if high > low else low + 1.0


def _beyond(values: Floats, low: float, high: float) -> str:
    finite = values[np.isfinite(values)]
    below, above = bool((finite < low).any()), bool((finite > high).any())
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")
