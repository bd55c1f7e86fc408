"""Displacement against load along a path of loads: where stiffness seems negative (002, Fig. 2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.compensation.predict_result import LoadPath
from stiffcal.quantity import LENGTH
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def apparent_negative(path: LoadPath, axis: int) -> Booleans:
    """Return the steps of a path on which force and deflection along an axis run against each other.

    Returns
    -------
    (m - 1,) True where the change of deflection has the other sign than the change of force.
    """
    product = np.diff(path.force[:, axis]) * np.diff(path.deflection[:, axis])
    # A deflection that stands still but for rounding goes neither way.
    return np.asarray(product < -1e-9 * np.abs(product).max(initial=0.0), dtype=np.bool_)


@canvas.styled
def draw_load_path(path: LoadPath) -> Figure:
    """Draw deflection against force along x, y and z; stretches of apparent negative stiffness are thick and hatched.

    Parameters
    ----------
    path : predicted forces and deflections.

    Returns
    -------
    Figure; forces in N, deflections in one unit, base axes; named loads numbered in order.
    """
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 66)
    panels = figure.subplots(1, 3)
    unit = canvas.unit_of(LENGTH, path.deflection[:, :3])
    for axis, (letter, panel) in enumerate(zip(canvas.AXES_NAMES, panels, strict=True)):
        force, deflection = path.force[:, axis], path.deflection[:, axis] * unit.factor
        canvas.zero_lines(panel)
        panel.plot(
            force, deflection, color=canvas.COLOURS[0], linewidth=1.2, label="stiffness of the usual sign", zorder=3
        )
        against = apparent_negative(path, axis)
        for number, (start, stop) in enumerate(_stretches(against)):
            panel.plot(
                force[start:stop], deflection[start:stop], color=canvas.ACCENT, linewidth=2.6,
                linestyle=(0, (2.0, 0.7)), label="apparent negative stiffness" if number == 0 else None, zorder=4,
            )  # fmt: skip
        for number, corner in enumerate(path.corners):
            panel.plot(force[corner], deflection[corner], marker="o", markersize=3.5, color=canvas.INK, zorder=5)
            panel.annotate(
                str(number + 1),
                (force[corner], deflection[corner]),
                xytext=(4, 4),
                textcoords="offset points",
                zorder=6,
            )
        panel.margins(0.12)
        panel.set_xlabel(f"force F{letter} [N]")
        panel.set_ylabel(unit.in_brackets(f"deflection D{letter}"))
    handles = {
        label: handle for panel in panels for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    canvas.share_legend(figure, list(handles.values()))
    return figure


def _stretches(flags: Booleans) -> list[tuple[int, int]]:
    """Runs of True among the steps, as slices of the points they join."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int64), [0]])))
    return [(int(start), int(stop) + 1) for start, stop in zip(edges[::2], edges[1::2], strict=True)]
