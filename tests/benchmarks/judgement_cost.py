"""What a judgement costs, as a ratio to one matrix product of its columns in the same run, besides seconds and MB.

The product is that of all members' columns with each other, whitened rows: an exact comparison of all sets of one
model cannot do without it. How many products' worth of time, and how many times these columns, a judgement takes does
not depend on the machine, as long as its BLAS does. Processor time and the growth of resident memory of one process.
"""

from __future__ import annotations

import resource
import sys
import tempfile
from pathlib import Path
from time import process_time

import numpy as np

from stiffcal.judgement.judge import Judged
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.benchmarks.cost import STATES_PER_RUN, make_load_campaign, reported
from tests.calibration.numbers import of_practice

PRODUCTS, KILOBYTES = 40.0, 120.0
"""Limits: products' worth of time, and kB a state …"""
LARGE = 5000
"""… of so many states: of fewer, what libraries and catalogue take is more than that."""
PASSES = 3


def megabytes() -> float:
    """Return the largest resident size of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform != "darwin" else 1024**2)


def size_of_columns(judged: Judged) -> tuple[int, int]:
    """Return how many columns all members have, and of how many whitened rows."""
    return sum(len(one.columns.rows) for one in judged.members), len(judged.ground.white)


def seconds_of_product(count: int, rows: int) -> float:
    """Return the least of some processor times of so many columns' inner products."""
    columns, found = np.random.default_rng(1).normal(size=(count, rows)), []
    for _ in range(PASSES):
        began = process_time()
        columns @ np.ascontiguousarray(columns[::-1]).T
        found.append(process_time() - began)
    return min(found)


def main(states: int = LARGE) -> bool:
    """Print the figures of a campaign of so many states, a play hidden in it; return whether all limits hold."""
    with tempfile.TemporaryDirectory(prefix="stiffcal-judged-") as place:
        (asked,) = of_practice([make_load_campaign(Path(place) / "loaded", states // STATES_PER_RUN)])
    before, began = megabytes(), process_time()
    judged = judge_states(asked.states, asked.model, built_in_effects())
    seconds, more = process_time() - began, megabytes() - before
    count, rows = size_of_columns(judged)
    product = seconds_of_product(count, rows)
    print(
        f"judgement of {len(asked.states)} states, {count} columns of {rows} rows, {judged.rounds} models:"
        f" {seconds:.3g} s of processor time, {more:.3g} MB; one product of the columns: {product:.3g} s"
    )
    held = [reported("  over the product", seconds / product, PRODUCTS, " x")]
    kilobytes = 1024.0 * more / len(asked.states)
    print(f"  memory over that of the columns: {more * 2**20 / (8.0 * count * rows):.3g} x, {kilobytes:.3g} kB a state")
    if len(asked.states) >= LARGE:
        held.append(reported("  memory", kilobytes, KILOBYTES, " kB a state"))
    return all(held)


if __name__ == "__main__":
    sys.exit(0 if main(*map(int, sys.argv[1:])) else 1)
