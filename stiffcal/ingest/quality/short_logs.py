"""Logs that end within their run: shorter than those of the run's other instruments, unlike in other runs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffcal.reduction.logs.summary import LogSummary
from stiffcal.uncertainty import MEDIAN_OF_NORMAL
from stiffcal.wording import significant

SURE = 5.0
"""Standard deviations by which a log is shorter: not by chance among a thousand logs."""
LEAST = 0.1
"""Of a run's length: with ten loads and more, one of them."""
FEWEST_RUNS = 3
"""Of which one can differ from the others."""


def short_logs(logs: Mapping[tuple[str, str, str], LogSummary]) -> list[str]:
    """Return a warning for every log that covers less of its run than those of its source in the other runs.

    Clocks need not agree: lengths are compared. Instruments that always begin late or end early are no fault.

    Parameters
    ----------
    logs : by source, file and run.
    """
    lengths: dict[str, dict[str, tuple[float, str]]] = {}
    for (source, file, run), log in logs.items():
        length = log.last_s - log.first_s
        if log.sampled and length > 0.0:
            lengths.setdefault(run, {})[source] = (length, file)
    shares: dict[str, list[tuple[float, str, str]]] = {}
    for run, of_run in lengths.items():
        for source in of_run:
            others = [other for other in of_run if other != source]
            if others:
                longest = max(others, key=lambda other: of_run[other][0])
                shares.setdefault(source, []).append((of_run[source][0] / of_run[longest][0], run, longest))
    warnings = []
    for source, of_source in shares.items():
        values = np.array([share for share, _, _ in of_source])
        usual = float(np.median(values))
        scatter = float(np.median(np.abs(values - usual))) / MEDIAN_OF_NORMAL
        if len(of_source) < FEWEST_RUNS:
            continue
        for share, run, longest in of_source:
            if share < min(usual, 1.0) - max(LEAST, SURE * scatter):
                length, file = lengths[run][source]
                other, other_file = lengths[run][longest]
                warnings.append(
                    f"{file}: it lasts {significant(length, 4)} s where {other_file} lasts "
                    f"{significant(other, 4)} s, unlike in other runs: "
                    "did it end early? Loads that it does not cover are not used; log again, or exclude the run"
                )
    return warnings
