"""What the judged campaigns say of a judge: rates by category, firm wrong names, and stated against observed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from tests.calibration.field_mix import CATEGORIES, NOISE_KNOWN
from tests.calibration.judging import JudgedCampaign
from tests.rates.intervals import clopper_pearson

BINS = (0.0, 0.2, 0.5, 0.8, 0.95, 0.99, 1.0)
"""Edges of the bins of stated probabilities."""


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
    return "\n".join([*lines, *_reliability(records), *_priors(records)])


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
    """Return each probability that was stated of a group of effects, and whether one of them is in the campaign."""
    return [
        (one.probability, bool(set(one.names) & set(record.truth)))
        for one in record.answer.named
        if not math.isnan(one.probability)
    ]


def _priors(records: Sequence[JudgedCampaign]) -> list[str]:
    """Return in how many campaigns each prior, three times larger or smaller, changes the verdict."""
    counts = Counter(prior for record in records for prior in record.answer.hangs_on)
    lines = ["verdicts that a factor of three in a prior changes"] if counts else []
    return lines + [f"{prior:<40}{n:>4} of {len(records)}" for prior, n in counts.most_common()]


def _reliability(records: Sequence[JudgedCampaign]) -> list[str]:
    pairs = [pair for record in records for pair in stated(record)]
    if not pairs:
        return []
    lines = ["stated of a group      mean   right    of   99 % interval"]
    for low, high in pairwise(BINS):
        own = [(p, right) for p, right in pairs if low <= p < high or (high == 1.0 and p == 1.0)]
        if own:
            right = sum(r for _, r in own)
            bounds = clopper_pearson(right, len(own), 0.99)
            mean = sum(p for p, _ in own) / len(own)
            lines.append(
                f"{low:.2f} to {high:.2f}        {mean:8.3f}{right:>8}{len(own):>6}   {bounds[0]:.3f}–{bounds[1]:.3f}"
            )
    return lines
