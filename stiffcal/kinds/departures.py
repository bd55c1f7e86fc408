"""Where readings leave the band of a fitted curve: their local mean lies outside it by more than chance does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.presentation.values import Digits, Line, Words
from stiffcal.wording import significant

# Readings of a stretch; their mean is judged.
_PER_STRETCH = 12
_MOST_STRETCHES = 12
# Standard errors of a stretch's mean that chance may add to the band.
_CHANCE = 3.0


@dataclass(frozen=True)
class Departure:
    """A stretch of the abscissa in which the readings leave the band."""

    low: float
    """Where it begins, in the abscissa's unit."""
    high: float
    """Where it ends."""
    mean: float
    """Mean of the readings less the curve, in the ordinate's unit."""


def find_departures(x: Floats, residual: Floats, half_band: Floats) -> list[Departure]:
    """Return the stretches in which the mean reading lies outside the band; neighbours on one side are joined.

    Parameters
    ----------
    x : (n,) abscissa. residual : (n,) readings less the curve. half_band : (n,) half width of the band there.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 120)
    >>> jump = np.where(x < 0.2, 1.0, 0.0) + 0.01 * np.sin(40.0 * x)
    >>> [(round(d.low, 2), round(d.high, 2), round(d.mean, 1)) for d in find_departures(x, jump, 0.0 * x + 0.1)]
    [(0.0, 0.19, 1.0)]
    """
    order = np.argsort(x, kind="stable")
    count = min(len(order) // _PER_STRETCH, _MOST_STRETCHES)
    if count < 1:
        return []
    found: list[tuple[Departure, int]] = []
    previous = -2
    for number, members in enumerate(np.array_split(order, count)):
        mean = float(residual[members].mean())
        error = float(residual[members].std(ddof=1)) / np.sqrt(len(members))
        if abs(mean) <= float(half_band[members].mean()) + _CHANCE * error:
            continue
        low, high = float(x[members[0]]), float(x[members[-1]])
        if previous == number - 1 and found and found[-1][0].mean * mean > 0.0:
            last, n_last = found.pop()
            weight = n_last / (n_last + len(members))
            joined = Departure(last.low, high, weight * last.mean + (1.0 - weight) * mean)
            found.append((joined, n_last + len(members)))
        else:
            found.append((Departure(low, high, mean), len(members)))
        previous = number
    return [departure for departure, _ in found]


def departures_in_words(joints: Iterable[tuple[str, Sequence[Departure]]], unit: str, factor: float = 1.0) -> Words:
    """Return where the readings leave the band, joint by joint, as the end of a picture's caption.

    Parameters
    ----------
    joints : name and stretches of each, in N·m over the abscissa.
    unit : in which the abscissa is drawn. factor : to it.
    """
    words: list[str | Digits] = []
    for joint, departures in joints:
        for departure in departures:
            side = "above" if departure.mean > 0.0 else "below"
            begin = "; " if words else " On average the readings are outside the band (grey bars): "
            low, high = factor * departure.low, factor * departure.high
            # a stretch of one reading, or of several that are the same as printed
            alone = significant(low) == significant(high)
            words += [begin, f"{joint} at ", Digits(low)] if alone else [begin, f"{joint} from ", Digits(low)]
            words += [] if alone else [" to ", Digits(high)]
            words += [f" {unit}, ", Digits(abs(departure.mean), 2), f" N·m {side} the curve"]
    return (*words, ".") if words else (" The readings are within the band.",)


def departure_bars(
    x: Floats, curve: Floats, drawn: Booleans, departures: Iterable[Departure], factor: float = 1.0, label: str = ""
) -> list[Line]:
    """Return the mean of the readings of every stretch that is drawn, as a bar next to the curve.

    Parameters
    ----------
    x, curve : (n,) the curve. drawn : (n,) which of it the panel shows.
    departures : stretches of ``x``. factor : to the unit in which ``x`` is drawn. label : of the legend.
    """
    bars = []
    for departure in departures:
        inside = drawn & (x >= departure.low) & (x <= departure.high)
        if inside.any():
            mean = curve[inside] + departure.mean
            bars.append(Line(factor * x[inside], mean, width=2.6, colour="quiet", label=label))
    return bars
