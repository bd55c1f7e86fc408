"""The ladder of fits: from no model at all, fit by fit, down to the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stiffcal.report import wording
from stiffcal.report.figures import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@canvas.styled
def draw_ladder(
    fits: Sequence[dict[str, Any]],
    zero_model: dict[str, Any] | None,
    noise: dict[str, Any] | None,
    component: str = "translation",
) -> Figure:
    """Draw the error of each fit in unseen poses (filled) and on its own data (hollow), on a logarithmic scale.

    Parameters
    ----------
    fits : entries of the history document: ``{id, time, model, heldout_rms, fit_rms, noise}``.
    zero_model : rms with no model, from the validate document; None where not known.
    noise : the noise floor; None where it cannot be judged.
    component : "translation" or "rotation".

    Returns
    -------
    Figure; rms in mm or mrad.
    """
    unit = "mm" if component == "translation" else "mrad"
    steps: list[tuple[str, float | None, float | None]] = []
    if wording.part(zero_model, component) is not None:
        steps.append(("no model", wording.part(zero_model, component), None))
    for fit in fits:
        steps.append(
            (
                f"fit {fit['id']}: {_shortened(wording.model_words(fit.get('model')))}",
                wording.part(fit.get("heldout_rms"), component),
                wording.part(fit.get("fit_rms"), component),
            )
        )
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 24 + 8 * len(steps))
    axes = figure.subplots()
    axes.set_xscale("log")
    for row, (_, unseen, fitted) in enumerate(steps):
        if fitted is not None:
            axes.plot(fitted * 1e3, row, marker="D", markersize=7.5, color=canvas.INK, markerfacecolor="none", zorder=3)
        if unseen is not None:
            axes.plot(unseen * 1e3, row, marker="o", markersize=4.5, color=canvas.COLOURS[0], zorder=4)
            label = wording.digits(unseen * 1e3)
            axes.annotate(
                f"{label} {unit}",
                (unseen * 1e3, row),
                xytext=(7, 0),
                textcoords="offset points",
                va="center",
                fontsize=6.5,
            )
        elif fitted is None:
            axes.annotate(
                "not fitted yet",
                (0.98, row),
                xycoords=axes.get_yaxis_transform(),
                ha="right",
                va="center",
                fontsize=6.5,
            )
    handles = _legend(axes, wording.part(noise, component))
    low, high = _limits([value for _, *pair in steps for value in pair] + [wording.part(noise, component)])
    axes.set_xlim(low, high)
    axes.set_ylim(len(steps) - 0.5, -0.5)
    axes.set_yticks(range(len(steps)), [label for label, *_ in steps])
    axes.xaxis.set_major_formatter(lambda value, _: wording.digits(value, 1))
    axes.xaxis.set_minor_formatter(lambda value, _: wording.digits(value, 1) if f"{value:e}"[0] in "25" else "")
    axes.set_xlabel(f"{component} error, rms length [{unit}], logarithmic")
    canvas.share_legend(figure, handles)
    return figure


def _limits(values: Sequence[float | None]) -> tuple[float, float]:
    known = [value * 1e3 for value in values if value]
    return (min(known) / 1.6, max(known) * 2.2) if known else (0.1, 1.0)


def _shortened(text: str, limit: int = 46) -> str:
    return text if len(text) <= limit else text[: limit - 1] + "…"


def _legend(axes: Any, noise: float | None) -> list[Any]:
    from matplotlib.lines import Line2D

    handles: list[Any] = [
        Line2D([], [], linestyle="none", marker="o", markersize=4.5, color=canvas.COLOURS[0], label="in unseen poses"),
        Line2D(
            [],
            [],
            linestyle="none",
            marker="D",
            markersize=7.5,
            color=canvas.INK,
            markerfacecolor="none",
            label="on the fitted data",
        ),
    ]
    if noise is not None:
        axes.axvline(noise * 1e3, color=canvas.ACCENT, linestyle=(0, (5, 2)), linewidth=1.1)
        handles.append(Line2D([], [], color=canvas.ACCENT, linestyle=(0, (5, 2)), label="noise floor"))
    return handles
