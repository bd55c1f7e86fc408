"""Block averages hold what the samples hold, in bounded memory, however the log is cut into batches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiffcal.reduction.logs.blocks import BlockAverager, blocks_of, noise_of


@settings(max_examples=40)
@given(st.lists(st.integers(1, 60), min_size=1, max_size=12), st.integers(4, 64), st.integers(0, 1000))
def test_blocks_give_the_samples_sums(sizes: list[int], most: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    n = sum(sizes)
    time = np.cumsum(generator.uniform(0.001, 0.02, n))
    values = 1000.0 + generator.normal(size=(3, n))
    averager = BlockAverager(most=most)
    start = 0
    for size in sizes:
        averager.add(time[start : start + size], {"wrench": values[:, start : start + size]})
        start += size
    blocks = averager.blocks()
    assert len(blocks) <= most
    assert blocks.count.sum() == n
    mean = (blocks.mean["wrench"] * blocks.count[:, None]).sum(axis=0) / n
    np.testing.assert_allclose(mean, values.mean(axis=1), rtol=1e-12)
    within = (blocks.variance["wrench"] * (blocks.count - 1)[:, None]).sum(axis=0)
    between = (blocks.count[:, None] * (blocks.mean["wrench"] - mean) ** 2).sum(axis=0)
    np.testing.assert_allclose(within + between, values.var(axis=1) * n, rtol=1e-6, atol=1e-9)
    assert blocks.start[0] == pytest.approx(time[0])
    assert blocks.end[-1] == pytest.approx(time[-1])
    assert (np.diff(blocks.time) > 0).all()


def test_a_slow_log_keeps_every_sample() -> None:
    time = np.arange(0.0, 10.0, 0.04)
    blocks = blocks_of(time, {"position": np.random.default_rng(0).normal(size=(time.size, 3))})
    np.testing.assert_allclose(blocks.time, time)
    assert blocks.interval == pytest.approx(0.04)


def test_quaternions_of_either_sign_are_averaged_as_one() -> None:
    quaternion = np.array([[0.6, 0.8, 0.0, 0.0], [-0.6, -0.8, 0.0, 0.0]]).T
    averager = BlockAverager(shortest=1.0)
    averager.add(np.array([0.0, 0.1]), {"quaternion.target": quaternion})
    np.testing.assert_allclose(averager.blocks().mean["quaternion.target"], [[0.6, 0.8, 0.0, 0.0]])


def test_samples_with_a_missing_value_are_left_out() -> None:
    averager = BlockAverager(shortest=1.0)
    averager.add(np.array([0.0, 0.1, 0.2]), {"marker.a": np.array([[1.0, np.nan, 3.0]])})
    blocks = averager.blocks()
    assert averager.dropped == 1
    assert blocks.mean["marker.a"][0, 0] == 2.0


def test_noise_is_not_found_in_ramps_and_steps() -> None:
    generator = np.random.default_rng(2)
    values = generator.normal(0.0, 0.5, (4000, 2))
    values += 100.0 * np.floor(np.arange(4000) / 500.0)[:, None] + 0.3 * np.arange(4000)[:, None]
    np.testing.assert_allclose(noise_of(values), 0.5, rtol=0.06)


def test_blocks_stay_even_when_they_double() -> None:
    averager = BlockAverager(most=64)
    for k in range(40):
        averager.add(k + np.linspace(0.0, 0.99, 100), {"wrench": np.ones((1, 100))})
    blocks = averager.blocks()
    assert len(blocks) <= 64
    assert blocks.count[:-1].max() <= blocks.count[:-1].min() + 2
