"""Every true hold is found once, none is invented."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.reduction.holds.finding import Holds, find_holds
from stiffcal.reduction.holds.unused import UnusedCode
from stiffcal.reduction.logs.blocks import blocks_of
from tests.laboratory.hidden_campaigns import raw_runs, true_holds
from tests.laboratory.made_up_logs import load_cycle


def matches(found: Holds, true: Floats) -> Floats:
    """Return (h,) the share of each true hold that its best found hold covers; each found hold has to serve one."""
    assert len(found) == len(true)
    shared = np.minimum(found.end[:, None], true[:, 1]) - np.maximum(found.start[:, None], true[:, 0])
    assert (np.argmax(shared, axis=1) == np.arange(len(true))).all()
    return np.asarray(np.diag(shared) / (true[:, 1] - true[:, 0]))


def test_raw_logs_give_the_holds_of_the_table() -> None:
    for run in raw_runs():
        true = true_holds(run.states.run[0])
        assert matches(run.holds, true).min() > 0.8
        union = np.maximum(run.holds.end, true[:, 1]) - np.minimum(run.holds.start, true[:, 0])
        shared = np.minimum(run.holds.end, true[:, 1]) - np.maximum(run.holds.start, true[:, 0])
        assert (shared / union).min() > 0.8


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"noise": 5.0},
        {"noise": 0.0},
        {"ramp": 0.02},
        {"ramp": 0.001},
        {"ramp": 8.0, "hold": 4.0},
        {"rate": 1000.0},
        {"rate": 5.0},
        {"settle": 0.15},
        {"breaks": True},
        {"lead": 120.0},
        {"hold": 60.0, "ramp": 3.0, "rate": 20.0, "lead": 60.0},
        {"hold": 20.0, "lead": 3.0},
    ],
    ids=str,
)
def test_holds_of_made_up_logs(how: dict[str, Any]) -> None:
    time, wrench, true = load_cycle(np.random.default_rng(5), **how)
    blocks = blocks_of(time, {"wrench": wrench})
    found = find_holds(blocks.time, blocks.mean["wrench"])
    # the first and the last hold are open ended: cut to the usual length
    assert matches(found, true)[1:-1].min() > 0.7
    usual = np.median(found.end - found.start)
    assert (found.end - found.start)[[0, -1]].max() < 1.3 * usual


def test_spikes_do_not_cut_holds() -> None:
    generator = np.random.default_rng(6)
    time, wrench, true = load_cycle(generator)
    wrench[generator.integers(0, len(time), 60)] += 200.0 * generator.normal(size=(60, 6))
    assert matches(find_holds(time, wrench), true)[1:-1].min() > 0.8


def test_smooth_noise_of_a_filtered_sensor_is_no_load() -> None:
    generator = np.random.default_rng(12)
    time, wrench, true = load_cycle(generator, noise=0.0)
    noise = generator.normal(size=wrench.shape)
    for k in range(1, len(noise)):
        noise[k] = 0.8 * noise[k - 1] + 0.6 * noise[k]
    found = find_holds(time, wrench + 1.5 * noise)
    assert matches(found, true)[1:-1].min() > 0.8


@pytest.mark.parametrize("rate", [5.0, 100.0, 1000.0, 5000.0])
@pytest.mark.parametrize("noise", [0.0, 1.0, 5.0])
def test_loads_that_jump_within_one_sample_are_held(rate: float, noise: float) -> None:
    generator = np.random.default_rng(31)
    true, levels = dead_weights(generator, 20)
    time = np.arange(0.0, true[-1, 1], 1.0 / rate)
    wrench = levels[np.searchsorted(true[:, 1], time, side="right").clip(max=19)]
    blocks = blocks_of(time, {"wrench": wrench + noise * generator.normal(size=wrench.shape)})
    # the open ends are cut to the usual length
    assert matches(find_holds(blocks.time, blocks.mean["wrench"]), true)[1:-1].min() > 0.8


def test_jumps_under_smooth_noise_are_held() -> None:
    generator = np.random.default_rng(32)
    true, levels = dead_weights(generator, 20)
    time = np.arange(0.0, true[-1, 1], 0.01)
    wrench = levels[np.searchsorted(true[:, 1], time, side="right").clip(max=19)]
    noise = generator.normal(size=wrench.shape)
    for k in range(1, len(noise)):
        noise[k] = 0.9 * noise[k - 1] + np.sqrt(0.19) * noise[k]
    assert matches(find_holds(time, wrench + 5.0 * noise), true)[1:-1].min() > 0.8


@pytest.mark.parametrize("seed", [0, 2, 4])
def test_slices_of_long_noisy_ramps_are_no_holds(seed: int) -> None:
    generator = np.random.default_rng(seed)
    begin = 8.0 * np.arange(20)
    true = np.stack([begin, begin + 5.0], axis=1)
    force = 500.0 * generator.normal(size=(20, 3))
    force[0] = 0.0
    levels = np.concatenate([force, np.cross([0.1, 0.05, 0.2], force)], axis=1)
    time = np.arange(0.0, true[-1, 1], 0.01)
    wrench = np.stack([np.interp(time, true.ravel(), np.repeat(level, 2)) for level in levels.T], axis=1)
    noise = generator.normal(size=wrench.shape) * np.array([5.0, 5.0, 5.0, 0.5, 0.5, 0.5])
    assert matches(find_holds(time, wrench + noise), true)[1:-1].min() > 0.8


def dead_weights(generator: np.random.Generator, n: int) -> tuple[Floats, Floats]:
    """Return (n, 2) holds of some five seconds without pause, and (n, 6) loads: hung on one by one, then changed."""
    edges = np.concatenate([[0.0], np.cumsum(5.0 * generator.uniform(0.7, 1.3, n))])
    levels = np.zeros((n, 6))
    levels[:, 2] = -100.0 * np.arange(n)
    levels[n // 2 :, :3] = 500.0 * generator.normal(size=(n - n // 2, 3))
    return np.stack([edges[:-1], edges[1:]], axis=1), levels


def test_what_is_dropped_is_said() -> None:
    time, wrench, true = load_cycle(np.random.default_rng(7), lead=30.0)
    found = find_holds(time, wrench)
    assert {stretch.code for stretch in found.dropped} >= {UnusedCode.LOAD_CHANGING, UnusedCode.BEFORE_FIRST_LOAD}
    assert len(found) == len(true)


def test_settling_is_left_out_of_the_mean() -> None:
    time, wrench, _ = load_cycle(np.random.default_rng(8), settle=0.15)
    _, ideal, true = load_cycle(np.random.default_rng(8), noise=0.0)
    found = find_holds(time, wrench)
    for k in range(1, len(true) - 1):
        inside = (time >= found.start[k]) & (time <= found.end[k])
        level = ideal[int((true[k, 0] + 1.0) * 100.0), :3]
        assert np.abs(wrench[inside, :3].mean(axis=0) - level).max() < 1.0


def test_noise_alone_is_one_hold_and_a_ramp_none() -> None:
    time = np.arange(0.0, 30.0, 0.01)
    noise = np.random.default_rng(9).normal(size=(time.size, 6))
    assert len(find_holds(time, noise)) == 1
    assert len(find_holds(time, noise + 20.0 * time[:, None])) == 0
