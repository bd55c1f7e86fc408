"""Pictures as plain values: panels with points, curves and bands; a module of its own, as few answers have any."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stiffcal.arrays import Floats, Integers
from stiffcal.presentation.words import Words

Colour: TypeAlias = int | Literal["model", "quiet"]
"""A colour of the palette by its number, the model's, or that of what is not important."""


@dataclass(frozen=True)
class Marks:
    """Points of a picture."""

    x: Floats
    """(n,)"""
    y: Floats
    """(n,)"""
    marker: str
    """"^", "v", "o", "x", or "0", "1", … for the n-th of the palette."""
    colour: Colour
    size: float = 3.0
    """Points of print."""
    edge: float = 0.7
    """Points of print."""
    is_hollow: bool = True
    opacity: float = 1.0
    label: str = ""
    """In the legend; "" where it stands in none."""
    layer: float = 3.0
    """Higher ones cover lower ones."""
    spread: Floats | None = None
    """(n,) half the height of a bar through the point; None: no bar."""
    note: str = ""
    """Written above the last point, upright."""
    run: str = ""
    """The run that all points are of; "" of several."""
    sweep: Literal["", "up", "down", "both"] = ""
    """Of a clamped run's points whose y is the torque on the moved joint: the half sweeps that they are of, by the
    direction of the angle; "" where they stand for the whole run."""
    rows: Integers | None = None
    """(n,) rows of the kind's table of fitted readings; None where a point is not one of them."""


@dataclass(frozen=True)
class Line:
    """A curve of a picture."""

    x: Floats
    """(n,)"""
    y: Floats
    """(n,)"""
    width: float = 1.1
    """Points of print."""
    is_dashed: bool = False
    colour: Colour = "model"
    label: str = ""
    layer: float = 4.0


@dataclass(frozen=True)
class Band:
    """What lies between two curves of a picture."""

    x: Floats
    """(n,)"""
    low: Floats
    """(n,)"""
    high: Floats
    """(n,)"""
    label: str = ""
    layer: float = 1.0


@dataclass(frozen=True)
class Span:
    """A stretch of the x axis over the whole height."""

    low: float
    high: float
    label: str = ""
    layer: float = 0.0


Series: TypeAlias = Marks | Line | Band | Span


@dataclass(frozen=True)
class Panel:
    """A pair of axes with what is drawn in it."""

    title: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]
    x_limits: tuple[float, float] | None = None
    """None: what the series need."""
    y_limits: tuple[float, float] | None = None
    """None: what the series need."""
    head_room: float | None = None
    """The y axis begins at zero or below and has this share left above the series; None: it does not."""
    x_names: tuple[str, ...] = ()
    """Written at 0, 1, … of the x axis instead of numbers."""
    y_names: tuple[str, ...] = ()
    """Likewise of the y axis."""
    x_ticks: int | None = None
    """So many numbers at the x axis at most."""
    has_zero_lines: bool = False
    has_own_legend: bool = False
    """Its labels stand in the panel, not above all panels."""
    empty: str = ""
    """Where there is nothing to draw: why."""
    joint: str = ""
    """The joint that it shows alone; pages in a browser show one joint at a time."""


@dataclass(frozen=True)
class Picture:
    """Panels side by side, row by row."""

    panels: tuple[Panel, ...]
    columns: int
    height: float
    """mm, of the whole."""
    caption: Words = ()
    widths: tuple[float, ...] = ()
    """Of the columns, relative to each other; empty: equal."""


def scattered(x: Floats, y: Floats, x_label: str, y_label: str) -> Picture:
    """Return points in one pair of axes.

    Parameters
    ----------
    x, y : (n,) in the units that the labels name. x_label, y_label : of the axes.
    """
    panel = Panel("", x_label, y_label, (Marks(x, y, "o", "model"),), has_zero_lines=True)
    return Picture((panel,), columns=1, height=55.0, caption=(f"{y_label} over {x_label}.",))
