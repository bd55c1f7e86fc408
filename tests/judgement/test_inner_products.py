"""Inner products against dense algebra, and what many columns and many runs cost."""

from __future__ import annotations

import sys
import tracemalloc
from dataclasses import dataclass
from types import FrameType

import numpy as np
import pytest

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement import inner_products
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy, LouderRun
from stiffcal.judgement.ground_of_rows import RowData
from stiffcal.judgement.inner_products import InnerProducts
from stiffcal.judgement.numbers import NO_DISCREPANCY, ROUNDING
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.space import ReadStates
from stiffcal.judgement.tails import Readings

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


def test_parts_of_members_are_made_again_where_there_is_no_room(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(6)
    shared = shared_of(rng, 20)
    columns = [(rng.normal(size=(2, 20 * PER_RUN)), None) for _ in range(4)]
    all_kept, few_kept = (InnerProducts.of(shared, columns, columns[0][0][0]) for _ in range(2))
    kept = all_kept.of_set([0, 1, 2, 3]).gram
    monkeypatch.setattr("stiffcal.judgement.inner_products.MOST_SPLIT", 2 * all_kept.parts[0].size)
    np.testing.assert_array_equal(few_kept.of_set([0, 1, 2, 3]).gram, kept)
    assert (len(all_kept.parts), len(few_kept.parts)) == (4, 2)


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
    scale[2, run == 2] = 0.0
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


def test_what_lasts_in_single_runs_counts_as_columns_of_its_own_variance_would() -> None:
    rng = np.random.default_rng(8)
    run = np.repeat([3, 4, 5], [12, 7, 4])
    space = WhitenedRows(RowData(run), rng.uniform(0.5, 2.0, (2, 23)), independent=False)
    makes, drivers = 2.0 * rng.normal(size=(2, 2, 23)), list(rng.normal(size=(2, 23)))
    makes[1, :, run == 4], makes[:, :, run == 5] = 0.0, 0.0
    common, white, rows = rng.normal(size=(2, 46)), rng.normal(size=46), rng.normal(size=(3, 46))
    lasting = Discrepancy.of_lasting(space, makes, run)
    as_columns, as_variance = (_kinds(space, drivers, run, lasting, next_to) for next_to in (None, lasting))
    prior = np.zeros((4, 7))
    prior[:, 2:6] = np.eye(4)
    columns = np.concatenate([common, *(space.rows(makes * (run == k)) for k in (3, 4))])
    both = Shared(columns, prior, as_columns), Shared(common, np.zeros((0, 3)), as_variance, lasting)
    one, other = (InnerProducts.of(shared, [(rows, None)], white) for shared in both)
    np.testing.assert_allclose(other.own[0], one.own[0], rtol=1e-7)
    np.testing.assert_allclose(other.target[0], one.target[0], atol=1e-7)
    np.testing.assert_allclose(other.square, one.square, rtol=1e-7)
    np.testing.assert_allclose(np.ptp(other.constant - one.constant), 0.0, atol=1e-7)
    left = [Readings(shared, white, np.ones(46), np.zeros(46, dtype=np.int64)) for shared in both]
    for number in range(len(both[0].grid)):
        np.testing.assert_allclose(both[1].reduced(rows, number), both[0].reduced(rows, number), atol=1e-7)
        (_, free), (_, as_free) = (readings.left(one, [], np.zeros(0), number) for readings in left)
        np.testing.assert_allclose(as_free, free, atol=1e-7)


def _kinds(
    space: WhitenedRows, drivers: list[Floats], run: Integers, lasting: Discrepancy, next_to: Discrepancy | None
) -> list[tuple[Discrepancy | LouderRun, float]]:
    """Return responses to drivers and a louder run, next to what lasts or without it."""
    place, basis, variance = lasting.of_run[0]
    q = 0 if next_to is None else len(variance)
    louder = LouderRun(3, space.scale.size, place, float(len(place)), basis[:, :q], variance[:q])
    return [(Discrepancy.of_drivers(space, drivers, run, next_to), 0.3), (louder, 0.2)]


def test_several_threads_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the last bit, in the order of the members, with more stacks of columns than threads."""
    rng = np.random.default_rng(8)
    shared, white = shared_of(rng, 8), rng.normal(size=8 * PER_RUN)
    columns = [(rng.normal(size=(1 + k % 3, 8 * PER_RUN)), None) for k in range(20)]
    monkeypatch.setattr(inner_products, "NUMBERS_AT_ONCE", 4 * 8 * PER_RUN)
    one, other = (InnerProducts.of(shared, columns, white, jobs) for jobs in (1, 3))
    assert [part.shape[1] for part in other.own] == [len(rows) for rows, _ in columns]
    for a, b in zip([*one.own, *one.target], [*other.own, *other.target], strict=True):
        assert np.array_equal(a, b)
