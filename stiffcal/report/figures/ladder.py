"""The ladder of fits: from no model at all, fit by fit, down to the noise floor."""

from __future__ import annotations

import itertools
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stiffcal.quantity import ShownUnit, of_measure
from stiffcal.report import wording
from stiffcal.report.figures import canvas
from stiffcal.results.model_words import model_change, model_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiffcal.measurements.rms import Rms
    from stiffcal.model.summary import ModelSummary
    from stiffcal.results.history_results import HistoryEntry, StoredFit

_LABEL_WIDTH = 46
# Name of each measure of an error.
_TITLES = {
    "translation": "translation error, rms length",
    "rotation": "rotation error, rms length",
    "motor_angle": "error of clamped motors' angles, rms",
    "torque": "error of drives' torques in motion, rms",
}
# Steps that change the error by less than this factor are not worth a number.
_SIGNIFICANT = 1.05


@dataclass(frozen=True)
class Rung:
    """One step of the ladder: the fit after one more effect."""

    label: str
    """The effect that the model gained, or that there is none."""
    heldout: float | None
    """rms residual in poses left out of the fit, m or rad; None where not known."""
    fitted: float | None
    """rms residual of the fitted data, m or rad; None where not known."""


@canvas.styled
def draw_ladder(
    fits: Sequence[HistoryEntry],
    zero_model: Rms | None,
    noise: Rms | None,
    component: str = "translation",
) -> Figure:
    """Draw the error of each fit in held-out poses (filled) and on its own data (hollow), on a logarithmic scale.

    Parameters
    ----------
    fits : in the order in which they are drawn.
    zero_model : rms with no model; None where not known.
    noise : the noise floor; None where it cannot be judged.
    component : "translation", "rotation", "motor_angle" or "torque".

    Returns
    -------
    Figure; rms in one unit.
    """
    rungs = ladder_rungs(fits, zero_model, component)
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 26 + 8 * len(rungs))
    handles = fill_ladder(figure.subplots(), rungs, wording.part(noise, component), component, (_LABEL_WIDTH, 2))
    canvas.share_legend(figure, handles)
    return figure


def fill_ladder(
    axes: Axes, rungs: Sequence[Rung], floor: float | None, component: str, label_size: tuple[int, int]
) -> list[Any]:
    """Draw rungs into a panel, and return what its legend shows.

    Parameters
    ----------
    axes : the panel. rungs : from the top down. floor : the noise, m or rad; None where it cannot be judged.
    component : as for `draw_ladder`. label_size : letters in a line of a rung's label, and lines at most.
    """
    errors = [value for rung in rungs for value in (rung.heldout, rung.fitted)]
    unit = of_measure(component).unit_for([*errors, floor])
    factor = unit.factor
    axes.set_xscale("log")
    _draw_steps(axes, rungs, factor)
    above: float | None = None
    for row, rung in enumerate(rungs):
        _draw_rung(axes, row, rung, unit, above)
        above = rung.heldout or above
    floor = None if floor is None else factor * floor
    handles = _legend(axes, floor)
    known = [factor * value for value in errors if value]
    low, high = _limits([*known, floor])
    axes.set_xlim(low, high)
    if floor is not None:
        axes.axvspan(low, floor, color=canvas.PALE, alpha=0.5, linewidth=0, zorder=0.2)
    axes.set_ylim(len(rungs) - 0.5, -0.5)
    axes.set_yticks(range(len(rungs)), ["\n".join(label_lines(rung.label, label_size)) for rung in rungs])
    axes.xaxis.set_major_formatter(lambda value, _: wording.significant(value, 1))
    axes.xaxis.set_minor_formatter(lambda value, _: wording.significant(value, 1) if f"{value:e}"[0] in "25" else "")
    axes.set_xlabel(f"{unit.in_brackets(_TITLES[component])}, logarithmic")
    return handles


def label_lines(label: str, size: tuple[int, int]) -> list[str]:
    r"""Return a rung's label in lines of so many letters, shortened at a word after so many lines.

    A place stays whole: "(joint" with the number in the next line is read as a word of its own.

    Examples
    --------
    >>> label_lines("fit 2: + backlash (joint 4)", (25, 2))
    ['fit 2: + backlash', '(joint\xa04)']
    """
    width, most_lines = size
    whole = re.sub(r"\((joints?|links?|pairs?) (?=[^ )]+\))", "(\\1\u00a0", label)
    return textwrap.wrap(whole, width, max_lines=most_lines, placeholder=" …", break_on_hyphens=False) or [""]


def leading_component(fits: Sequence[HistoryEntry | StoredFit]) -> str | None:
    """Return the measure that a ladder is drawn of first: the tool's place, clamped motors, torques; None for none."""
    return next(
        (
            name
            for name in ("translation", "motor_angle", "torque")
            if any(wording.part(fit.fit_rms, name) is not None for fit in fits)
        ),
        None,
    )


def ladder_rungs(fits: Sequence[HistoryEntry], zero_model: Rms | None, component: str) -> list[Rung]:
    """Return the rungs: no model, the first fit with its whole model, then what each fit gained or lost.

    Parameters
    ----------
    fits, zero_model, component : as for `draw_ladder`.
    """
    rungs = []
    if wording.part(zero_model, component) is not None:
        rungs.append(Rung("no model", wording.part(zero_model, component), None))
    before: ModelSummary | None = None
    for fit in fits:
        text = model_words(fit.model) if before is None else model_change(before, fit.model)
        label = f"fit {fit.id}: {text or 'the same model'}"
        rungs.append(Rung(label, wording.part(fit.heldout_rms, component), wording.part(fit.fit_rms, component)))
        before = fit.model
    return rungs


def _draw_steps(axes: Axes, rungs: Sequence[Rung], factor: float) -> None:
    """Join the errors in held-out poses by stairs."""
    known = [(row, rung.heldout * factor) for row, rung in enumerate(rungs) if rung.heldout]
    for (row, error), (below, lower) in itertools.pairwise(known):
        axes.plot([error, lower, lower], [row, row, below], color=canvas.COLOURS[0], linewidth=0.9, zorder=2, alpha=0.7)


def _draw_rung(axes: Axes, row: int, rung: Rung, unit: ShownUnit, above: float | None) -> None:
    """Draw one rung, with the factor by which it lowers or raises the error of the one above it."""
    if rung.fitted is not None:
        axes.plot(
            rung.fitted * unit.factor,
            row,
            marker="D",
            markersize=7.5,
            color=canvas.INK,
            markerfacecolor="none",
            zorder=3,
        )
    if rung.heldout is not None:
        axes.plot(rung.heldout * unit.factor, row, marker="o", markersize=4.5, color=canvas.COLOURS[0], zorder=4)
        text = wording.in_unit(rung.heldout, unit)
        factor = above / rung.heldout if above and rung.heldout else 1.0
        if max(factor, 1.0 / factor) > _SIGNIFICANT:
            sign = "÷" if factor > 1.0 else "×"
            text += f"  ({sign} {wording.significant(max(factor, 1.0 / factor), 2)})"
        axes.annotate(
            text, (rung.heldout * unit.factor, row), xytext=(8, -7 if above else 0), textcoords="offset points",
            va="center", fontsize=6.5, zorder=5, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.3},
        )  # fmt: skip
    elif rung.fitted is None:
        axes.annotate(
            "not fitted yet", (0.98, row), xycoords=axes.get_yaxis_transform(), ha="right", va="center", fontsize=6.5
        )


def _limits(values: Sequence[float | None]) -> tuple[float, float]:
    known = [value for value in values if value]
    if not known:
        return 0.1, 1.0
    # to the right there is room for the number of the largest error, a quarter of the panel
    return min(known) / 1.6, max(known) * max(2.2, (max(known) / min(known)) ** 0.33)


def _legend(axes: Axes, noise: float | None) -> list[Any]:
    from matplotlib.lines import Line2D

    handles: list[Any] = [
        Line2D(
            [], [], linestyle="none", marker="o", markersize=4.5, color=canvas.COLOURS[0], label="in held-out data"
        ),
        Line2D(
            [], [], linestyle="none", marker="D", markersize=7.5, color=canvas.INK, markerfacecolor="none",
            label="on the fitted data",
        ),
    ]  # fmt: skip
    if noise is not None:
        axes.axvline(noise, color=canvas.ACCENT, linestyle=(0, (5, 2)), linewidth=1.1)
        handles.append(Line2D([], [], color=canvas.ACCENT, linestyle=(0, (5, 2)), label="noise floor"))
    return handles
