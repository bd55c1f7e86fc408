"""Inner products against dense algebra, and what many columns and many runs cost."""

from __future__ import annotations

import sys
import tracemalloc
from types import FrameType

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.inner_products import InnerProducts
from stiffcal.judgement.numbers import NO_DISCREPANCY, ROUNDING
from stiffcal.judgement.shared import Shared

PER_RUN = 6
CLOSE = 100.0 * ROUNDING


def runs_of(rng: np.random.Generator, runs: int) -> Discrepancy:
    """Return a discrepancy of runs of six rows, with two directions each."""
    bases, _ = np.linalg.qr(rng.normal(size=(runs, PER_RUN, 2)))
    place, at = np.arange(runs * PER_RUN).reshape(runs, PER_RUN), np.arange(2 * runs).reshape(runs, 2)
    alike = AlikeRuns(np.arange(runs), place, bases, at)
    return Discrepancy(tuple(range(runs)), runs * PER_RUN, [alike], rng.uniform(0.5, 2.0, 2 * runs))


def shared_of(rng: np.random.Generator, runs: int) -> Shared:
    common = rng.normal(size=(2, runs * PER_RUN))
    return Shared(common, np.zeros((0, 3)), [(runs_of(rng, runs), 1.0 - NO_DISCREPANCY)])


def projected(shared: Shared, number: int) -> Floats:
    """Return P (r, r) of a discrepancy of the grid, by inverses of whole matrices."""
    r = shared.columns.shape[1]
    kind, weights, _ = shared.grid[number]
    inverse = np.eye(r)
    discrepancy, _ = shared.kinds[max(kind, 0)]
    assert isinstance(discrepancy, Discrepancy)
    if kind >= 0:
        at = 0
        for place, basis, variance in discrepancy.of_run:
            own = weights[at : at + len(variance)]
            inverse[np.ix_(place, place)] -= (basis * own) @ basis.T
            at += len(variance)
    x = shared.columns
    return inverse - inverse @ x.T @ np.linalg.inv(x @ inverse @ x.T) @ x @ inverse


def test_products_of_members_are_those_of_whole_matrices() -> None:
    rng = np.random.default_rng(2)
    shared = shared_of(rng, 4)
    r = 4 * PER_RUN
    rows, y = [rng.normal(size=(q, r)) for q in (1, 3, 2)], rng.normal(size=r)
    products = InnerProducts.of(shared, [(one, None) for one in rows], y)
    stack = np.concatenate(rows)
    inner = products.of_set([0, 1, 2])
    for t in range(len(shared.grid)):
        whole = projected(shared, t)
        np.testing.assert_allclose(inner.gram[t], stack @ whole @ stack.T, atol=CLOSE)
        np.testing.assert_allclose(inner.target[t], stack @ whole @ y, atol=CLOSE)
        np.testing.assert_allclose(inner.square[t], y @ whole @ y, atol=CLOSE)
        np.testing.assert_allclose(np.concatenate(products.across(1, t)), stack @ whole @ rows[1].T, atol=CLOSE)


def test_columns_of_one_run_count_as_among_those_of_all() -> None:
    rng = np.random.default_rng(3)
    shared = shared_of(rng, 4)
    r = 4 * PER_RUN
    short, long, y = rng.normal(size=(2, PER_RUN)), rng.normal(size=(1, r)), rng.normal(size=r)
    place = np.arange(PER_RUN, 2 * PER_RUN)
    dense = np.zeros((2, r))
    dense[:, place] = short
    one, other = (InnerProducts.of(shared, [own, (long, None)], y) for own in ((short, place), (dense, None)))
    np.testing.assert_allclose(one.of_set([0, 1]).gram, other.of_set([0, 1]).gram, atol=1e-12)
    np.testing.assert_allclose(one.across(1, 2)[0], other.across(1, 2)[0], atol=1e-12)
    np.testing.assert_allclose(one.reduced(0, 2), other.reduced(0, 2), atol=1e-12)


def test_many_columns_need_less_memory_than_their_products_have() -> None:
    """Of 800 columns all products at seven sizes are 36 MB, the columns 8 MB."""
    rng = np.random.default_rng(4)
    shared = shared_of(rng, 200)
    rows = [rng.normal(size=(8, 200 * PER_RUN)) for _ in range(100)]
    tracemalloc.start()
    products = InnerProducts.of(shared, [(one, None) for one in rows], rng.normal(size=200 * PER_RUN))
    for number in range(1, 20):
        products.of_set([0, number])
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 24e6


def test_more_runs_need_no_more_steps() -> None:
    """Absolute places are a run each: thousands of them."""

    def steps(runs: int) -> int:
        discrepancy = runs_of(np.random.default_rng(5), runs)
        rows, count = np.ones((3, runs * PER_RUN)), 0

        def counted(frame: FrameType, event: str, argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        sys.setprofile(counted)
        discrepancy.along(rows)
        discrepancy.taken_out(rows, discrepancy.weights(1.0))
        sys.setprofile(None)
        return count

    assert steps(400) == pytest.approx(steps(40), abs=5)
