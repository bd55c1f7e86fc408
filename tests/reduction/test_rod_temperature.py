"""Rods that get warmer with their link: taken out where expansions and temperature are known, named where not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.bodies.measured_links import measure_links
from stiffcal.identification.readings.observations import observe
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mistakes.rods.faults import find_rod_faults
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.reduction.states.rod_temperature import grown_lengths, smooth_in_time, without_growth
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.rod_states import bending_swing, five_rods, six_axes_with_beams, with_effect, with_rods
from tests.laboratory.simulated_states import joint_springs, played

# cast iron against Invar, the sun on a swing, a thermometer that scatters
EXPANSION, RATE, SCATTER = 9.3e-6, 20.0 / 3600.0, 0.02


@pytest.fixture(scope="module")
def robot() -> CompliantRobot:
    swing = bending_swing(EI2=4e6, EI3=6e6, GJ=3e6, EA=1.5e9)
    return with_effect(joint_springs(six_axes_with_beams(), SIX_STIFFNESS), swing)


@pytest.fixture(scope="module")
def cold(robot: CompliantRobot) -> LoadStates:
    """Rods of 0.2 µm; the runs are 200 s long."""
    return with_rods(played(robot, runs=6, noise=Sigma(10e-6, 20e-6)), robot, five_rods(robot.chain, sigma=2e-7))


@pytest.fixture(scope="module")
def warm(cold: LoadStates) -> LoadStates:
    """The same as it gets warmer: closed form, l (α_link − α_rod) (T − T_ref)."""
    (rods,) = cold.setup.rods
    warmer = RATE * cold.time
    read = 295.0 + warmer + SCATTER * np.random.default_rng(3).standard_normal(len(cold))
    grown = np.outer(warmer, [0.75, 0.7, 0.7, 0.35, 0.35]) * EXPANSION
    assert np.allclose(rods.length, [0.75, 0.7, 0.7, 0.35, 0.35])
    return replace(cold, lengths=cold.lengths + grown, temperature=read[:, None])


def grown_by(states: LoadStates, growth: object) -> LoadStates:
    (rods,) = states.setup.rods
    return replace(states, setup=replace(states.setup, rods=(replace(rods, growth=np.asarray(growth)),)))


def test_known_growth_is_taken_out(cold: LoadStates, warm: LoadStates) -> None:
    (rods,) = cold.setup.rods
    known = grown_by(warm, EXPANSION * rods.length)
    mended, largest = without_growth(known), float(np.abs(grown_lengths(known)).max())
    first = np.searchsorted(cold.run, cold.run)
    left = (mended.lengths - mended.lengths[first]) - (cold.lengths - cold.lengths[first])
    span = max(float(np.ptp(cold.time[cold.run == k])) for k in range(6))
    assert largest == pytest.approx(EXPANSION * 0.75 * RATE * span, rel=0.1)
    # three numbers of some twenty-five readings of 0.02 K, twice at the ends where the curve is known least
    assert np.sqrt(np.mean(left**2)) < 0.75 * EXPANSION * SCATTER
    assert np.sqrt(np.mean(left**2)) < 0.2 * largest


def test_what_is_not_known_stays(cold: LoadStates, warm: LoadStates) -> None:
    (rods,) = cold.setup.rods
    assert without_growth(warm) is warm
    some = np.where(np.arange(5) < 2, EXPANSION * rods.length, np.nan)
    mended = without_growth(grown_by(warm, some))
    assert np.array_equal(mended.lengths[:, 2:], warm.lengths[:, 2:])
    assert not np.allclose(mended.lengths[:, :2], warm.lengths[:, :2], rtol=0.0, atol=1e-7)
    blind = replace(warm, temperature=np.full((len(warm), 1), np.nan))
    assert not grown_lengths(grown_by(blind, EXPANSION * rods.length)).any()


def test_growth_that_is_not_known_is_named(robot: CompliantRobot, cold: LoadStates, warm: LoadStates) -> None:
    rigid = CompliantRobot(robot.chain, ())
    (link,) = measure_links(observe(warm, robot.chain), rigid)
    (fault,) = link.faults
    assert fault.kind == "warming"
    assert "µm per metre and kelvin" in fault.sentence
    assert "expansion_per_K" in fault.sentence
    steady = replace(cold, temperature=295.0 + SCATTER * np.random.default_rng(4).standard_normal((len(cold), 1)))
    (link,) = measure_links(observe(steady, robot.chain), rigid)
    assert link.faults == ()


def test_noise_estimated_from_repeats_does_not_hide_it(robot: CompliantRobot, warm: LoadStates) -> None:
    """Between repeats a cycle apart the growth is noise: held against that noise nothing would be wrong."""
    (rods,) = warm.setup.rods
    first = np.searchsorted(warm.run, warm.run)
    wide = replace(rods, sigma=np.full(5, 3e-6))
    lengths = warm.lengths - warm.lengths[first]
    (link,) = measure_links(observe(warm, robot.chain), CompliantRobot(robot.chain, ()))
    beam, warmth = warm.setup.beams[0], warm.temperature[:, 0]
    faults = find_rod_faults(wide, beam, lengths[link.index], link.wrench, warm.time, warm.run, warmth)
    assert [one.kind for one in faults] == ["warming"]


def test_a_slow_curve_is_kept_and_its_noise_is_not() -> None:
    time = np.linspace(0.0, 100.0, 81)
    curve = 295.0 + 0.1 * (1.0 - np.exp(-time / 300.0))
    noisy = curve + 0.05 * np.random.default_rng(1).standard_normal(81)
    assert np.sqrt(np.mean((smooth_in_time(time, noisy) - curve) ** 2)) < 0.05 * np.sqrt(2.0 * 3.0 / 81.0)
    assert np.array_equal(smooth_in_time(time[:8], noisy[:8]), noisy[:8])


def test_a_drift_that_repeats_take_for_noise_is_named(robot: CompliantRobot, cold: LoadStates) -> None:
    """Cycles apart the same load reads otherwise: held against the scatter of repeats a drift would be no fault."""
    (rods,) = cold.setup.rods
    drift = np.outer(cold.time - cold.time[np.searchsorted(cold.run, cold.run)], [0.0, 0.0, 0.0, 1.0, 0.0]) * 2e-8
    (link,) = measure_links(observe(cold, robot.chain), CompliantRobot(robot.chain, ()))
    lengths = cold.lengths - cold.lengths[np.searchsorted(cold.run, cold.run)] + drift
    wide = replace(rods, sigma=np.full(5, 2e-6))
    faults = find_rod_faults(wide, cold.setup.beams[0], lengths[link.index], link.wrench, cold.time, cold.run)
    assert [(one.kind, one.rods) for one in faults] == [("drifting", ("ids4",))]
