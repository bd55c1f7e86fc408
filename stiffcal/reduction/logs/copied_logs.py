"""Logs of runs that hold the readings of another run's log: copied as they are, or with fewer digits.

Of an instrument two readings differ by noise, also where a programme is run again. That two logs agree in all rows that
are compared is chance where noise is smaller than the last digit, which shows in how far a reading is from its
neighbours: rows that differ from these by more than rounding explains would differ between two runs as often.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.reduction.copies.by_chance import MOST_PROBABLE, probability_of_as_many
from stiffcal.reduction.copies.rounded import Layout, last_digits, printed_digits
from stiffcal.reduction.logs.sampled_readings import SampledReadings
from stiffcal.reduction.logs.summary import LogSummary

_Key = tuple[str, str, str]
"""Source, file and run."""
_HALF = 0.5 * (1.0 + 1e-6)  # of the last printed digit, what rounding changes; more by what binary numbers round
_ROUNDING = 1e-12  # of floating-point numbers, relative
_NO_STEP = 1e-9  # of a reading, relative: more digits than instruments have
_EQUAL_STEPS = 1e-6  # relative: more digits than what is stored of them
MOST_NAMED = 10


@dataclass(frozen=True)
class CopiedRuns:
    """Runs whose logs hold the same readings."""

    runs: tuple[str, ...]
    """In the order of the campaign; the first counts as the original."""
    files: tuple[str, ...]
    """Their logs that do, one source after the other."""


def copied_runs(logs: Mapping[_Key, LogSummary]) -> list[CopiedRuns]:
    """Return the runs whose logs hold the same readings, each group of runs once.

    Parameters
    ----------
    logs : what was seen of each log, by source, file and run.
    """
    alike: dict[tuple[str, Layout, int], list[_Key]] = {}
    for key, log in logs.items():
        if log.sampled and log.readings is not None:
            alike.setdefault((key[0], log.readings.layout, log.n_rows), []).append(key)
    chance = MOST_PROBABLE / max(
        sum(len(keys) * (len(keys) - 1) for keys in alike.values()), 1
    )  # of either log's noise
    files: dict[tuple[str, ...], dict[str, None]] = {}
    for keys in alike.values():
        readings = [own for key in keys if (own := logs[key].readings) is not None]
        for group in _groups(len(keys), _equal_pairs(readings, chance)):
            runs = tuple(keys[k][2] for k in group)
            files.setdefault(runs, {}).update(dict.fromkeys(keys[k][1] for k in group))
    return [CopiedRuns(runs, tuple(own)) for runs, own in files.items()]


def copied_log_warnings(found: Sequence[CopiedRuns]) -> list[str]:
    """Return a warning for runs whose logs hold the same readings; none where there are no such runs."""
    if not found:
        return []
    named = "; ".join(f"{_listed(own.runs)} ({', '.join(own.files)})" for own in found[:MOST_NAMED])
    more = f" and {len(found) - MOST_NAMED} more" if len(found) > MOST_NAMED else ""
    why = "readings that count twice make the noise appear smaller"
    mend = "name each run's own log in [[runs]], or remove the run"
    return [f"copied logs: the same readings in runs {named}{more}, exactly or rounded: {why}; {mend}"]


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


def _equal_pairs(readings: Sequence[SampledReadings], chance: float) -> Iterator[tuple[int, int]]:
    """Yield pairs of logs that agree in all rows, and would not by chance.

    Parameters
    ----------
    readings : of logs of one layout and length. chance : that counts as none.
    """
    if len(readings) < 2:
        return
    values = np.stack([own.values for own in readings])
    missing, values = np.isnan(values), np.nan_to_num(values)
    printed = _printed(values, readings[0].layout)
    noise = _beyond_steps(np.nan_to_num(np.stack([own.scatter for own in readings])), values)
    for one, others in _candidates(values, printed):
        size = np.maximum(printed[one], printed[others])
        rounded = np.abs(printed[one] - printed[others]) > _ROUNDING * size
        largest = np.where(rounded, _HALF * size, 0.0) + _ROUNDING * np.abs(values[one])
        agree = np.all(np.abs(values[others] - values[one]) <= largest, axis=(1, 2))
        agree &= np.all(missing[others] == missing[one], axis=(1, 2))
        for k in np.flatnonzero(agree):
            other = int(others[k])
            rows = len(values[one])
            noisy = max(int(np.any(noise[log] > largest[k], axis=1).sum()) for log in (one, other))
            if probability_of_as_many(rows, rows, rows - noisy, rows) <= chance:
                yield one, other


def _candidates(values: Floats, printed: Floats) -> Iterator[tuple[int, Integers]]:
    """Yield of each log the others that may agree with it by the means of the channels, each pair once.

    Parameters
    ----------
    values, printed : (n, k, c) readings and their last digits.
    """
    means = values.mean(axis=1)
    largest = printed.mean(axis=1).max(axis=0) + _ROUNDING * np.abs(values).max(axis=(0, 1))
    channel = int(np.argmax(np.ptp(means, axis=0) / np.maximum(largest, np.finfo(np.float64).tiny)))
    order = np.argsort(means[:, channel], kind="stable")
    sorted_means = means[order, channel]
    last = np.searchsorted(sorted_means, sorted_means + largest[channel], side="right")
    for place in np.flatnonzero(last > np.arange(1, len(last) + 1)):
        one, others = order[place], order[place + 1 : last[place]]
        others = others[np.all(np.abs(means[others] - means[one]) <= largest, axis=1)]
        if others.size:
            yield int(one), others


def _beyond_steps(scatter: Floats, values: Floats) -> Floats:
    """Return (n, k, c) how far readings are from their neighbours' mean beyond half of what their instrument resolves.

    Half a step is what readings without noise are off where they climb in steps, and the least that is not zero.

    Parameters
    ----------
    scatter, values : (n, k, c).
    """
    zero = _NO_STEP * np.abs(values).max(axis=1, keepdims=True)
    least = np.where(scatter > zero, scatter, np.inf).min(axis=1, keepdims=True)
    return np.asarray(np.maximum(scatter - (1.0 + _EQUAL_STEPS) * least, 0.0))


def _printed(values: Floats, layout: Layout) -> Floats:
    """Return (n, k, c) the size of the last digit that was printed of each reading; 0 where all digits are there.

    Parameters
    ----------
    values : (n, k, c) readings. layout : of the c channels.
    """
    rows = values.reshape(-1, values.shape[2])
    digits = last_digits(rows)
    printed = printed_digits(rows, digits, layout).reshape(values.shape)
    known = np.where(digits > 0.0, digits, np.inf).reshape(values.shape)
    start = 0
    for _, count in layout:
        own = slice(start, start + count)
        finest = known[:, :, own].min(axis=(1, 2), keepdims=True)  # zeros have as many decimals as the others
        printed[:, :, own] = np.maximum(printed[:, :, own], np.where(np.isfinite(finest), finest, 0.0))
        start += count
    return printed


def _groups(n: int, pairs: Iterator[tuple[int, int]]) -> list[list[int]]:
    """Return the members of each group that pairs connect, in order."""
    group = list(range(n))
    for one, other in pairs:
        first, second = sorted((group[one], group[other]))
        group = [first if own == second else own for own in group]
    members: dict[int, list[int]] = {}
    for k, own in enumerate(group):
        members.setdefault(own, []).append(k)
    return [own for own in members.values() if len(own) > 1]
