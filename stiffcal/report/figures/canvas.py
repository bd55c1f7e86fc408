"""How every picture looks, and how it is written: the same bytes for the same content.

Pictures must be readable in grey and by colour-blind readers: series differ by marker, line style or hatching first;
the colours stay close to Okabe and Ito's, and those used together differ in darkness too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, cast

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.quantity import Quantity, ShownUnit
from stiffcal.report.drawing_library import drawing_library
from stiffcal.report.figures.light_axes import lighten_axes
from stiffcal.report.figures.margins import place_panels
from stiffcal.report.fonts import make_drawable, silence_font_notices

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

P = ParamSpec("P")
R = TypeVar("R")

INK = "#1a1a1a"
MODEL = "#000000"
QUIET = "#8a8a8a"
PALE = "#d9d9d9"
ACCENT = "#D55E00"
ARROW = "#a33b00"
COLOURS = ("#00457a", "#D55E00", "#57b8a5", "#7a3e8e", "#E69F00", "#0072B2", "#CC79A7", "#8fa6b8")
BRANCH_COLOURS = {"loading": COLOURS[0], "unloading": COLOURS[1], "": "#4d4d4d"}
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "<", ">", "p", "h")
PAGE_WIDTH_MM = 170.0
AXES_NAMES = ("x", "y", "z")

_STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 7.0,
    "axes.titlesize": 7.5,
    "axes.titlelocation": "left",
    # A fixed height: matplotlib would else measure all labels to find out whether one is above the panel.
    "axes.titley": 1.0,
    "axes.labelsize": 7.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.use_mathtext": False,
    "axes.formatter.useoffset": False,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.5,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "lines.linewidth": 0.9,
    "lines.markersize": 3.0,
    "lines.markeredgewidth": 0.7,
    "hatch.linewidth": 0.5,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "white",
    # Names of runs and joints are the user's own; a dollar sign in one starts no formula.
    "text.parse_math": False,
    "pdf.fonttype": 42,
    "svg.hashsalt": "stiffcal",
}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Run a drawing function under the report's style, whatever the user's own matplotlib settings are.

    The panels of a figure that it returns are placed, unless a layout of matplotlib does that.
    """

    @wraps(draw)
    def under_style(*args: P.args, **kwargs: P.kwargs) -> R:
        matplotlib = drawing_library()
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(cast(Any, _STYLE))
            drawn = draw(*args, **kwargs)
            from matplotlib.figure import Figure

            if isinstance(drawn, Figure) and drawn.get_layout_engine() is None:
                place_panels(drawn)
            return drawn

    return under_style


def new_figure(width_mm: float, height_mm: float, constrained: bool = False) -> Figure:
    """Return an empty figure of that size, without pyplot.

    Parameters
    ----------
    width_mm, height_mm : its size.
    constrained : matplotlib's constrained layout places the panels, for pictures with colour bars; it takes twice as
        long as `place_panels`, which does it otherwise.
    """
    drawing_library()
    from matplotlib.figure import Figure

    return Figure(figsize=(width_mm / 25.4, height_mm / 25.4), layout="constrained" if constrained else None)


def save_figure(figure: Figure, path: Path, text_as_shapes: bool = True) -> None:
    """Write a picture as SVG, PDF or PNG, by the path's ending; no dates inside.

    Parameters
    ----------
    figure : what to write.
    path : where; `.svg`, `.pdf` or `.png`.
    text_as_shapes : SVG only: draw letters as outlines, which look the same on every machine. The report keeps them as
        text, so that the PDF can be searched.
    """
    matplotlib = drawing_library()
    kind = path.suffix.lower().lstrip(".")
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {"Software": None})
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        style = _STYLE | {"svg.fonttype": "path" if text_as_shapes else "none"}
        matplotlib.rcParams.update(cast(Any, style))
        if not make_drawable(figure):
            lighten_axes(figure)
        with silence_font_notices():
            figure.savefig(path, format=kind, metadata=metadata, dpi=200)


def in_legend(name: str) -> str:
    """Return a name as a label that matplotlib shows: one that begins with an underscore is hidden in legends."""
    return f"\u200c{name}" if name.startswith("_") else name


def thinned(size: Floats, limit: int) -> Integers:
    """Pick at most about `limit` of the entries to draw: evenly spread ones, and always the twenty largest of `size`.

    A vector picture of 200 000 markers helps nobody; captions give the number that is drawn.
    """
    n = int(size.shape[0])
    if n <= limit:
        return np.arange(n)
    even = np.linspace(0, n - 1, limit).round().astype(np.int64)
    largest = np.argsort(np.nan_to_num(size))[-20:]
    return np.unique(np.concatenate([even, largest]))


def padded_limits(values: Sequence[float] | Floats, share: float = 0.06) -> tuple[float, float]:
    """Axis limits around the finite values, zero included; never of no width."""
    finite = np.asarray(values, dtype=np.float64)
    finite = finite[np.isfinite(finite)]
    low, high = (min(0.0, float(finite.min())), max(0.0, float(finite.max()))) if finite.size else (0.0, 1.0)
    width = (high - low) or 1.0
    return low - share * width, high + share * width


def unit_of(quantity: Quantity, *values: Floats) -> ShownUnit:
    """Return the one unit of all that panels show of a quantity, by the largest number, SI."""
    return quantity.unit_for(float(np.nanmax(np.abs(one), initial=0.0)) for one in values)


def zero_lines(axes: Axes) -> None:
    """Draw thin lines through the origin, which then lies within the panel."""
    from matplotlib.lines import Line2D

    # Not axhline: it works out the limits of all panels that share the axis, each time.
    across, up = axes.get_yaxis_transform(), axes.get_xaxis_transform()
    for x, y, transform in (((0.0, 1.0), (0.0, 0.0), across), ((0.0, 0.0), (0.0, 1.0), up)):
        line = Line2D(x, y, transform=transform, color=QUIET, linewidth=0.5, zorder=0.5)
        axes.add_artist(line)
    axes.update_datalim([(0.0, 0.0)])


def share_legend(figure: Figure, handles: Sequence[Any]) -> None:
    """Put one legend above all panels, in a strip of its own, with as many columns as the widest entry leaves."""
    if handles:
        # A letter of 6.5 pt takes about 1.35 mm, the mark and the gaps around it 11 mm.
        widest = max(11.0 + 1.35 * len(str(handle.get_label())) for handle in handles)
        rows = -(-len(handles) // max(1, min(len(handles), int(PAGE_WIDTH_MM / widest))))
        # rows as long as each other
        columns = -(-len(handles) // rows)
        outside = figure.get_layout_engine() is not None
        figure.legend(handles=list(handles), loc="outside upper center" if outside else "upper center", ncols=columns)
