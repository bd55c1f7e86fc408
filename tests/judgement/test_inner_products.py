"""Inner products against dense algebra, and what many columns and many runs cost."""

from __future__ import annotations

import sys
import tracemalloc
from dataclasses import dataclass
from types import FrameType

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.ground_of_rows import RowData
from stiffcal.judgement.inner_products import InnerProducts
from stiffcal.judgement.numbers import NO_DISCREPANCY, ROUNDING
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.space import ReadStates

PER_RUN = 6


@dataclass(frozen=True)
class WhitenedRows:
    """Weights of m components in n states without constants, as of `stiffcal.judgement.space.Space`."""

    data: ReadStates
    scale: Floats
    independent: bool

    @property
    def free(self) -> Floats:
        return np.ones_like(self.scale)

    def rows(self, stack: Floats) -> Floats:
        return np.asarray((stack * self.scale).reshape(len(stack), -1))

    def unwhitened(self, rows: Floats) -> Floats:
        return np.asarray(rows.reshape(self.scale.shape) / self.scale)


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


def test_components_that_err_by_themselves_have_the_same_discrepancy_in_less_room() -> None:
    rng = np.random.default_rng(5)
    run, scale = np.repeat([0, 1, 2], [5, 5, 7]), rng.uniform(0.5, 2.0, (3, 17))
    drivers, rows = list(rng.normal(size=(2, 17))), rng.normal(size=(4, 3 * 17))
    whole, apart = (
        Discrepancy.of_drivers(WhitenedRows(RowData(run), scale, independent), drivers, run)
        for independent in (False, True)
    )
    assert apart.log_determinant(0.7) == pytest.approx(whole.log_determinant(0.7))
    left = [one.taken_out(rows, one.weights(0.7)) for one in (whole, apart)]
    np.testing.assert_allclose(left[1], left[0], atol=1e-12)
    for number, (place, moved) in apart.moves.items():
        own, as_whole = whole.moves[number]
        variance = np.zeros((2, rows.shape[1], rows.shape[1]))
        variance[0][np.ix_(place, place)], variance[1][np.ix_(own, own)] = moved @ moved.T, as_whole @ as_whole.T
        np.testing.assert_allclose(variance[0], variance[1], atol=1e-12)
    room = [sum(one.basis.size for one in kind.alike) for kind in (whole, apart)]
    assert 3 * room[1] == room[0]
