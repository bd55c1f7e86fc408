"""`python -m tests.rates.geometry --seed N`: robots whose lengths and angles are not those of the robot file.

How often the 95 % intervals of ``identify`` hold the true compliances, with the geometry's tolerance in them and
without it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.mechanics.chain import GeometryTolerance
from tests.rates.intervals import clopper_pearson
from tests.rates.playing import GEOMETRY_OFF, Hidden, simulate_runs
from tests.rates.workers import one_thread_each


def play(seed: int, number: int) -> Hidden:
    """Draw a campaign of a robot whose geometry is off by the tolerance, with nothing else hidden."""
    return simulate_runs("only geometry off", np.random.default_rng([seed, 0, number]))


def inside(job: tuple[int, int]) -> tuple[list[bool], list[bool], list[float]]:
    """Return for each compliance whether the interval holds the truth, with and without geometry, and its share."""
    campaign = play(*job)
    # As of a robot file without [geometry]: absolute places count.
    tolerance = GeometryTolerance(*GEOMETRY_OFF, stated=False)
    model = replace(campaign.model, chain=replace(campaign.model.chain, tolerance=tolerance))
    fit = identify_parameters(campaign.states, model)
    truth = campaign.truth.values()
    answers: tuple[list[bool], list[bool], list[float]] = ([], [], [])
    for found, both in ((answers[1], fit), (answers[0], with_geometry(fit, campaign.states))):
        for parameter in both.parameters:
            if parameter.interval is None or parameter.at_bound:
                continue
            low, high = parameter.interval
            found.append(low <= truth[parameter.name] <= high)
            if found is answers[0]:
                answers[2].append(parameter.from_geometry or 0.0)
    return answers


def main(arguments: Sequence[str]) -> int:
    """Draw, fit, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.rates.geometry", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args(arguments)
    with one_thread_each(chosen.workers) as pool:
        results = list(pool.map(inside, [(chosen.seed, number) for number in range(chosen.count)]))
    for words, place in (("with geometry", 0), ("without", 1)):
        held = [bool(hit) for result in results for hit in result[place]]
        low, high = clopper_pearson(sum(held), len(held))
        print(f"{words}: {sum(held)} of {len(held)} intervals hold the truth ({100 * low:.1f}–{100 * high:.1f} %)")
    shares = [share for result in results for share in result[2]]
    print(
        f"share of the variance from geometry: median {np.median(shares):.2f}, above a half in "
        f"{np.mean(np.array(shares) > 0.5):.0%}"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
