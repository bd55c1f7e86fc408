"""Logs that end before their run does."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffcal.ingest.quality.short_logs import short_logs
from stiffcal.reduction.logs.summary import LogSummary


def summary(file: str, length: float) -> LogSummary:
    return LogSummary(file, True, {}, {}, 100, length / 99, 5.0, 5.0 + length, length / 99, {}, {})


def logs_of(lengths: Mapping[str, tuple[float, float]]) -> dict[tuple[str, str, str], LogSummary]:
    found = {}
    for run, of_run in lengths.items():
        for source, length in zip(("ft", "tracker"), of_run, strict=True):
            found[source, f"raw/{run}_{source}.csv", run] = summary(f"raw/{run}_{source}.csv", length)
    return found


def test_a_log_that_ends_within_its_run_is_named() -> None:
    lengths = {f"p{k}": (180.0 + 0.5 * k, 182.0 + 0.3 * k) for k in range(6)}
    (warning,) = short_logs(logs_of(lengths | {"p3": (120.0, 183.0)}))
    assert warning.startswith("raw/p3_ft.csv: ")
    (warning,) = short_logs(logs_of(lengths | {"p3": (181.0, 90.0)}))
    assert warning.startswith("raw/p3_tracker.csv: ")


def test_instruments_that_begin_or_end_elsewhere_in_every_run_are_no_fault() -> None:
    generator = np.random.default_rng(3)
    always_short = {f"p{k}": (60.0 + k, 180.0) for k in range(6)}
    by_hand = {f"p{k}": (180.0, float(180.0 - generator.uniform(0, 90))) for k in range(12)}
    assert short_logs(logs_of(always_short)) == []
    assert short_logs(logs_of(by_hand)) == []
    assert short_logs(logs_of({"p1": (180.0, 20.0), "p2": (180.0, 180.0)})) == []
