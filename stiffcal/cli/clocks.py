"""How the answers of `check` and `ingest` show clocks that run beside each other."""

from __future__ import annotations

from collections.abc import Iterable
from math import sqrt

from stiffcal.cli.answers import Document


def clock_rates(runs: Iterable[Document]) -> list[str]:
    """Return a line for every two clocks whose rates were compared: the weighted mean over the runs.

    Examples
    --------
    >>> clock = {"value": 0.2, "std": 1e-3, "rate": 3e-5, "rate_std": 1e-5, "rate_against": "ft"}
    >>> clock_rates([{"clock_ahead_s": {"tracker": clock}}])
    ['the clock of tracker gains +30 ± 20 ppm on that of ft']
    """
    sums: dict[tuple[str, str], list[float]] = {}
    for run in runs:
        for source, clock in (run.get("clock_ahead_s") or {}).items():
            if not isinstance(clock, dict) or not clock.get("rate_std"):
                continue
            weight = clock["rate_std"] ** -2
            told = sums.setdefault((source, clock["rate_against"]), [0.0, 0.0, 0.0])
            for k, value in enumerate((1.0, weight, weight * clock["rate"])):
                told[k] += value
    return [
        f"the clock of {source} gains {1e6 * product / weight:+.0f} ± {1.96e6 / sqrt(weight):.0f} ppm on that of "
        f"{against}" + (f", mean of {count:.0f} runs" if count > 1 else "")
        for (source, against), (count, weight, product) in sums.items()
    ]
