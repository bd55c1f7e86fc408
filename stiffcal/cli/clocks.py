"""How the answers of `check` and `ingest` show clocks that run in parallel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import sqrt
from typing import TYPE_CHECKING

from stiffcal.quantity import RATE
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from stiffcal.reduction.clocks.offsets import SourceClockOffset


def clock_rates(runs: Iterable[Mapping[str, SourceClockOffset]]) -> list[str]:
    """Return a line for every two clocks whose rates were compared: the weighted mean over the runs.

    Examples
    --------
    >>> from stiffcal.reduction.clocks.offsets import SourceClockOffset
    >>> clock_rates([{"tracker": SourceClockOffset(0.2, 1e-3, "", 3e-5, 1e-5, "ft")}])
    ['the clock of tracker gains +30 ± 20 ppm on that of ft']
    """
    sums: dict[tuple[str, str], list[float]] = {}
    for clocks in runs:
        for source, clock in clocks.items():
            if clock.rate is None or not clock.rate_std:
                continue
            weight = clock.rate_std**-2
            total = sums.setdefault((source, clock.rate_against), [0.0, 0.0, 0.0])
            for k, value in enumerate((1.0, weight, weight * clock.rate)):
                total[k] += value
    return [
        f"the clock of {source} gains {RATE.usual.factor * product / weight:+.0f} ± "
        f"{RATE.usual.factor * NORMAL_95 / sqrt(weight):.0f} {RATE.usual.name} on "
        f"that of {against}" + (f", mean of {count:.0f} runs" if count > 1 else "")
        for (source, against), (count, weight, product) in sums.items()
    ]
