"""One component of the residual against one quantity, on given axes: for notebooks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiffcal.arrays import Floats
from stiffcal.quantity import ANGLE, LENGTH
from stiffcal.report.drawing_library import drawing_library

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class ScatterContent:
    """What is drawn; n points."""

    values: Floats
    """(n,) what the residual may follow."""
    label: str
    """Its name and unit."""
    residual: Floats
    """(n,) m or rad, NaN where not measured."""
    component: str
    """Of the residual."""
    rotation: bool
    """Whether the residual is an angle."""
    shades: Floats | None
    """(n,) what colours the points."""
    shade_label: str
    """Its name and unit."""


def draw_residual_scatter(content: ScatterContent, axes: Axes | None) -> Axes:
    """Draw the points; without axes on new ones, which a notebook shows by itself.

    Parameters
    ----------
    content : what is drawn.
    axes : where; their figure's own style is kept.
    """
    drawing_library()
    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.subplots()[1]
    # the usual unit, whatever the residual's size: pictures of two models compare
    unit = (ANGLE if content.rotation else LENGTH).usual
    residual = unit.factor * content.residual
    axes.axhline(0.0, color="0.7", linewidth=0.8)
    if content.shades is None:
        axes.scatter(content.values, residual, s=12)
    else:
        points = axes.scatter(content.values, residual, s=12, c=content.shades)
        axes.get_figure(root=True).colorbar(points, ax=axes, label=content.shade_label)  # type: ignore[union-attr]
    axes.set_xlabel(content.label)
    axes.set_ylabel(unit.in_brackets(f"residual {content.component}"))
    return axes
