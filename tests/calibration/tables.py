"""What the judged campaigns say of a judge: rates by category, firm wrong names, and stated against observed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize

from stiffcal.arrays import Floats
from tests.calibration.field_mix import CATEGORIES, NOISE_KNOWN
from tests.calibration.judging import JudgedCampaign
from tests.rates.intervals import clopper_pearson

BINS = (0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 1.0)
"""Edges of the bins of stated probabilities."""
RESAMPLED = 200
"""Times that campaigns are drawn anew for an interval."""
STANDARD_ERRORS = 4.0
"""With which an oracle, who knows all else, finds an effect of which it is asked whether it is named."""
ABOUT_ONE = (0.7, 1.4)
"""Noises that count as one."""
LEAST_DOUBT = 1e-3
"""Stated probabilities are held between this and one less it: what is printed has no more digits."""


def table(records: Sequence[JudgedCampaign]) -> str:
    """Return rates by category and by how the noise is known, and the reliability of stated probabilities."""
    lines = [f"{'campaigns':<16}{'good':>6}{'of':>5}{'rate':>8}   95 % interval  firm wrong  outcomes"]
    groups: list[tuple[str, list[JudgedCampaign]]]
    groups = [(name, [r for r in records if r.category == name]) for name in CATEGORIES]
    groups += [(name, [r for r in records if r.noise == name]) for name in NOISE_KNOWN]
    groups.append(("all", list(records)))
    lines += [_line(name, own, name in CATEGORIES) for name, own in groups if own]
    seconds = sorted(r.answer.seconds for r in records if not r.answer.crash)
    if seconds:
        lines.append(f"processor time: median {seconds[len(seconds) // 2]:.1f} s, most {seconds[-1]:.1f} s")
    return "\n".join([*lines, *_reliability(records), *_names(records), *_priors(records)])


def _line(name: str, own: Sequence[JudgedCampaign], with_outcomes: bool) -> str:
    good = sum(r.good for r in own)
    low, high = clopper_pearson(good, len(own))
    firm = sum(bool(r.firm_wrong) for r in own)
    counts = ", ".join(f"{n} {word}" for word, n in Counter(r.outcome for r in own).most_common(6))
    return (
        f"{name:<16}{good:>6}{len(own):>5}{100 * good / len(own):>7.1f}%   {100 * low:5.1f}–{100 * high:5.1f} %"
        f"  {firm:>10}  {counts if with_outcomes else ''}"
    )


def stated(record: JudgedCampaign) -> list[tuple[float, bool]]:
    """Return each probability that was stated of a group, and whether one of the whole group is in the campaign."""
    return [
        (one.probability, one.holds(record.truth, record.runs))
        for one in record.answer.named
        if not math.isnan(one.probability)
    ]


def _priors(records: Sequence[JudgedCampaign]) -> list[str]:
    """Return in how many campaigns each prior, three times larger or smaller, changes the verdict."""
    counts = Counter(prior for record in records for prior in record.answer.hangs_on)
    lines = ["verdicts that a factor of three in a prior changes"] if counts else []
    return lines + [f"{prior:<40}{n:>4} of {len(records)}" for prior, n in counts.most_common()]


def of_effects(record: JudgedCampaign) -> list[tuple[float, bool]]:
    """Return the probability of each effect that has `LEAST`, and whether it is in the campaign."""
    return [(p, name in record.truth) for name, p in record.answer.effects.items()]


def _reliability(records: Sequence[JudgedCampaign]) -> list[str]:
    """Return stated against observed of groups, of which those of a half and more are stated, and of single effects."""
    lines = []
    for name, pairs_of in (("a group", stated), ("an effect", of_effects)):
        pairs = [pair for record in records for pair in pairs_of(record)]
        if not pairs:
            continue
        lines.append(f"{f'stated of {name}':<20}   mean   right    of   99 % interval")
        for low, high in pairwise(BINS):
            own = [(p, right) for p, right in pairs if low <= p < high or (high == 1.0 and p >= 1.0)]
            if own:
                right = sum(r for _, r in own)
                bounds = clopper_pearson(right, len(own), 0.99)
                mean = sum(p for p, _ in own) / len(own)
                lines.append(
                    f"{low:.2f} to {high:.2f}        {mean:8.3f}{right:>8}{len(own):>6}   "
                    f"{bounds[0]:.3f}–{bounds[1]:.3f}"
                )
        slope, score, of_base_rate = recalibrated(pairs)
        low, high = _slopes(records, pairs_of)
        lines.append(
            f"recalibration slope {slope:.2f} ({low:.2f} to {high:.2f}); log score {score:.4f}, "
            f"of the base rate {of_base_rate:.4f}"
        )
    return lines


def _slopes(
    records: Sequence[JudgedCampaign], pairs_of: Callable[[JudgedCampaign], list[tuple[float, bool]]]
) -> tuple[float, float]:
    """Return the 95 % interval of the recalibration slope by bootstrap over campaigns; infinite where none is wrong."""
    rng, slopes = np.random.default_rng(1), []
    for _ in range(RESAMPLED):
        drawn = rng.integers(len(records), size=len(records))
        slope = recalibrated([pair for k in drawn for pair in pairs_of(records[k])])[0]
        slopes.append(math.inf if math.isnan(slope) else slope)
    low, high = np.quantile(slopes, [0.025, 0.975], method="nearest")
    return float(low), float(high)


def recalibrated(pairs: Sequence[tuple[float, bool]]) -> tuple[float, float, float]:
    """Return the slope of log odds over those that were stated, the log score, and that of the rate alone.

    The slope is that of a logistic regression; NaN where all or none are right.
    """
    if not pairs:
        return math.nan, math.nan, math.nan
    p = np.clip([p for p, _ in pairs], LEAST_DOUBT, 1.0 - LEAST_DOUBT)
    right = np.array([right for _, right in pairs], dtype=np.float64)
    score = float(np.mean(np.where(right == 1.0, np.log(p), np.log1p(-p))))
    rate = float(right.mean())
    if rate in (0.0, 1.0):
        return math.nan, score, 0.0
    columns, sign = np.column_stack([np.ones_like(p), np.log(p / (1.0 - p))]), 2.0 * right - 1.0

    def less(values: Floats) -> float:
        return float(np.logaddexp(0.0, -sign * (columns @ values)).sum())

    found = minimize(less, np.array([0.0, 1.0]))
    return float(found.x[1]), score, rate * math.log(rate) + (1.0 - rate) * math.log1p(-rate)


def _names(records: Sequence[JudgedCampaign]) -> list[str]:
    """Return how often the names that are given hold the effect that is there, and how many they are."""
    sizes, held, found = [], 0, 0
    firm, alone = 0, 0
    for record in records:
        if record.category not in ("one", "several"):
            continue
        for name, size in zip(record.truth, record.sizes, strict=True):
            if size * math.sqrt(record.readings) < STANDARD_ERRORS:
                continue
            own = next((one for one in record.answer.named if name in one.names), None)
            found, held = found + 1, held + (own is not None)
            sizes += [] if own is None else [len(own.names)]
            if (
                record.category == "one"
                and ABOUT_ONE[0] <= size <= ABOUT_ONE[1]
                and (own is None or len(own.names) < 2)
            ):
                alone, firm = alone + 1, firm + (own is not None and own.firm and own.names[0] == name)
    if not found:
        return []
    lines = [f"effects of {STANDARD_ERRORS:g} standard errors and more that are among the names: {held} of {found}"]
    if sizes:
        lines[0] += f"; names: {float(np.median(sizes)):g} in the median, {np.mean(sizes):.2f} in the mean"
    return [*lines, f"single effects of about one noise, not alike another: firm and right {firm} of {alone}"]
