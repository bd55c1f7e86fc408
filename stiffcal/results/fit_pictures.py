"""Pictures that show whether a fit's statistics hold: residuals against a normal law, what each run does, correlations.

Each is a `Picture` of plain values, drawn like those of kinds of experiment.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.profiles import REACH, Profile
from stiffcal.presentation.pictures import Band, Line, Marks, Panel, Picture, Series, Span
from stiffcal.quantity import quantity_of
from stiffcal.wording import estimate, significant

MOST_POINTS = 300
"""Points of a sample that are drawn: those at both ends all, between them evenly spread ones."""
ENDS = 20
"""So many at each end."""
MOST_PARAMETERS = 8
"""Parameters whose changes have a colour of their own: those that a single run changes most."""
MOST_NAMES = 40
"""Runs whose names stand below the axis; more are counted."""
HEIGHT_MM, ROW_MM = 72.0, 3.2
"""Height of a picture, and of a row of the correlations."""
LARGEST_PT = 9.0
MOST_NUMBERS = 30
"""Of more parameters every fifth number is written below the correlations: two digits would touch the next two."""
"""Side of the square of a correlation of ± 1, points of print."""
PROFILE_COLUMNS, PROFILE_MM = 2, 58.0
"""Panels of profiles in a row, and the height of one."""
STEPS = 10
"""Sizes of the squares in which correlations are drawn, a tenth each."""


def normal_picture(residuals: Mapping[str, Floats]) -> Picture:
    """Return the residuals in order against what a normal law expects, with the band of chance.

    The band holds each of n ordered residuals by itself in 95 of 100 samples: of the i-th the quantiles of a Beta law
    with i and n + 1 − i (David and Nagaraja 2003, Order Statistics, section 2.1).

    Parameters
    ----------
    residuals : per kind of reading (n,) independent residuals of unit variance, in standard deviations of the noise.
    """
    panels = tuple(_normal_panel(name, values) for name, values in residuals.items() if values.size)
    return Picture(panels, max(len(panels), 1), HEIGHT_MM)


def _normal_panel(name: str, values: Floats) -> Panel:
    from scipy.special import betaincinv, ndtri

    n = values.size
    rank = _drawn(n) + 1
    expected = ndtri((rank - 0.375) / (n + 0.25))
    low, high = (np.asarray(ndtri(betaincinv(rank, n + 1 - rank, share)), dtype=np.float64) for share in (0.025, 0.975))
    series: list[Series] = [
        Band(expected, low, high, label="95 % of chance"),
        Line(expected, expected, is_dashed=True, label="normal law"),
        Marks(expected, np.sort(values)[rank - 1], "o", 0, size=2.5, label="residuals"),
    ]
    return Panel(
        name, "expected of a normal law [standard deviations]", "residual [standard deviations]", tuple(series),
        has_zero_lines=True,
    )  # fmt: skip


def _drawn(n: int) -> Integers:
    """Return the places, in order, of those of n values that are drawn."""
    if n <= MOST_POINTS:
        return np.arange(n)
    between = np.linspace(ENDS, n - ENDS - 1, MOST_POINTS - 2 * ENDS).round().astype(np.int64)
    return np.unique(np.concatenate([np.arange(ENDS), between, np.arange(n - ENDS, n)]))


def influence_picture(names: Sequence[str], runs: Sequence[str], changes: Floats) -> Picture:
    """Return how far each parameter moves when a run is left out.

    Parameters
    ----------
    names : of p parameters. runs : of F runs.
    changes : (F, p) in standard uncertainties of the fit with all runs, NaN where the other runs do not determine it.
    """
    largest = np.nan_to_num(np.abs(changes)).max(axis=0, initial=0.0)
    leading = np.argsort(-largest, kind="stable")[:MOST_PARAMETERS]
    x = np.arange(len(runs), dtype=np.float64)
    series: list[Series] = [
        Band(np.array([-0.5, len(runs) - 0.5]), np.full(2, -1.0), np.full(2, 1.0), label="one standard uncertainty")
    ]
    for i, k in enumerate(np.setdiff1d(np.arange(len(names)), leading)):
        series.append(Marks(x, changes[:, k], "o", "quiet", size=2.0, label="" if i else "other parameters"))
    series += [Marks(x, changes[:, k], str(i), i, label=names[k]) for i, k in enumerate(leading)]
    alone = np.flatnonzero(np.isnan(changes).any(axis=1))
    if alone.size:
        series.append(Marks(x[alone], np.zeros(alone.size), "x", "model", size=6.0, label="determines a value alone"))
    few = len(runs) <= MOST_NAMES
    panel = Panel(
        "Influence of each run",
        "run that is left out" if few else f"run that is left out, counted: {runs[0]} … {runs[-1]}",
        "change of the value [standard uncertainties]", tuple(series), x_names=tuple(runs) if few else (),
        has_zero_lines=True, empty="" if names else "the model has no free parameter",
    )  # fmt: skip
    return Picture((panel,), 1, HEIGHT_MM)


def correlation_picture(names: Sequence[str], covariance: Floats) -> Picture:
    """Return the correlations of parameters as squares, the larger the closer to ± 1.

    Parameters
    ----------
    names : of p parameters. covariance : (p, p).
    """
    std = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(std, std)
    row, column = np.tril_indices(len(names), -1)
    value = correlation[row, column]
    series: list[Series] = []
    for sign, colour, label in ((1.0, 0, "positive"), (-1.0, 1, "negative")):
        step = np.where(np.sign(value) == sign, np.ceil(np.abs(value) * STEPS - 1e-9), 0.0).astype(np.int64)
        for k in np.unique(step[step > 0]).tolist():
            own, share = step == k, k / STEPS
            series.append(
                Marks(column[own].astype(np.float64), row[own].astype(np.float64), "s", colour, size=LARGEST_PT * share,
                      is_hollow=False, label=f"{label}, up to {share:.1f}" if k == step.max() else "")
            )  # fmt: skip
    edge, every = len(names) - 0.5, 1 if len(names) <= MOST_NUMBERS else 5
    panel = Panel(
        "Correlations", "number of the parameter", "", tuple(series),
        x_names=tuple(str(k) if k % every == 0 else "" for k in range(1, len(names) + 1)),
        y_names=tuple(f"{name}  {k}" for k, name in enumerate(names, start=1)), x_limits=(-0.5, edge),
        y_limits=(edge, -0.5), empty="" if len(names) > 1 else "a single parameter has no correlation",
    )  # fmt: skip
    return Picture((panel,), 1, max(HEIGHT_MM, 40.0 + ROW_MM * len(names)))


def history_picture(fits: Sequence[str], errors: Floats, noise: Floats, measure: str) -> Picture:
    """Return the error in held-out data of each fit of the history, next to the noise.

    Parameters
    ----------
    fits : F names, oldest first. errors, noise : (F,) in the unit of `measure`, NaN where not known.
    measure : what is drawn, with its unit.
    """
    x = np.arange(len(fits), dtype=np.float64)
    series: list[Series] = [
        Line(x, errors, colour=0), Marks(x, errors, "o", 0, size=5.0, is_hollow=False, label="error, held out"),
    ]  # fmt: skip
    if np.isfinite(noise).any():
        # a single fit has a line too
        ends = np.concatenate([x[:1] - 0.5, x, x[-1:] + 0.5]), np.concatenate([noise[:1], noise, noise[-1:]])
        series.append(Line(*ends, is_dashed=True, colour="quiet", label="noise"))
    empty = "" if np.isfinite(errors).any() else "no fit of the history was validated"
    panel = Panel("History of fits", "fit", measure, tuple(series), x_names=tuple(fits), head_room=0.1, empty=empty)
    return Picture((panel,), 1, HEIGHT_MM)


def profile_picture(found: Sequence[Profile], intervals: Mapping[str, tuple[float, float] | None]) -> Picture:
    """Return the sums of squares over parameters near a bound or that bend their law, and both forms of interval.

    Parameters
    ----------
    found : the profiles. intervals : full name to the interval that the fit states, as values; None: there is none.
    """
    panels = tuple(_profile_panel(one, intervals.get(one.name)) for one in found)
    none = Panel("", "", "", (), empty="no parameter bends its law or is near a bound: the stated intervals hold")
    rows = max(-(-len(panels) // PROFILE_COLUMNS), 1)
    return Picture(panels or (none,), min(max(len(panels), 1), PROFILE_COLUMNS), 12.0 + PROFILE_MM * rows)


def _profile_panel(profile: Profile, stated: tuple[float, float] | None) -> Panel:
    drawn = np.isfinite(profile.values) & np.isfinite(profile.rise)
    shown = quantity_of(profile.spec.unit).unit_for(profile.values[drawn].tolist())
    unit, factor = shown.name, shown.factor
    x = factor * profile.values[drawn]
    if not x.size:
        return Panel(profile.name, "", "", (), empty="nothing of it can be computed")
    series: list[Series] = [
        Line(x, profile.rise[drawn], colour=0, label="sum of squares, all others free"),
        Line(x, profile.parabola[drawn], is_dashed=True, colour="quiet", label="parabola of the standard uncertainty"),
        Line(x[[0, -1]], np.full(2, profile.level), width=0.7, colour=1, label="95 %"),
    ]
    low, high = (None if end is None else factor * end for end in (profile.low, profile.high))
    span = Span(x[0] if low is None else low, x[-1] if high is None else high, label="95 % interval by the profile")
    series.insert(0, span)
    title = f"{profile.name}\nby the profile: {_by_the_profile(profile, factor)} {unit}".rstrip()
    if stated is not None:
        ends = [factor * end if math.isfinite(end) else None for end in stated]
        title += f"\nby the parabola: {estimate(_finite(profile.estimate, factor), ends)} {unit}".rstrip()
    return Panel(
        title, f"value [{unit}]" if unit else "value", "rise [variances of the noise]", tuple(series),
        x_limits=(float(x[0]), float(x[-1])), y_limits=(0.0, 3.0 * profile.level), x_ticks=5,
    )  # fmt: skip


def _by_the_profile(profile: Profile, factor: float) -> str:
    """Return the estimate with its interval; an end that lies beyond what was computed is no open end."""
    low, high = (None if end is None else factor * end for end in (profile.low, profile.high))
    # a profile that ends nearer than its reach ends at a bound
    beyond = [
        end is None and profile.parabola[k] > 0.99 * REACH**2 for k, end in ((0, profile.low), (-1, profile.high))
    ]
    if not any(beyond):
        return estimate(_finite(profile.estimate, factor), [low, high])
    ends = [
        f"beyond {significant(factor * profile.values[k])}" if out else "its limit" if end is None else significant(end)
        for k, end, out in zip((0, -1), (low, high), beyond, strict=True)
    ]
    return f"{significant(_finite(profile.estimate, factor))} ({' … '.join(ends)})"


def _finite(value: float, factor: float) -> float | None:
    """Return a value in the unit that is printed; None where it is infinite."""
    return factor * value if math.isfinite(value) else None


def in_standard_uncertainties(steps: Floats, covariance: Floats) -> Floats:
    """Return (F, p) changes of p parameters over their standard uncertainties; covariance (p, p)."""
    return np.asarray(steps / np.sqrt(np.maximum(np.diag(covariance), 1e-300)), dtype=np.float64)


__all__ = [
    "correlation_picture",
    "history_picture",
    "in_standard_uncertainties",
    "influence_picture",
    "normal_picture",
    "profile_picture",
]
