"""A force sensor whose zero moves within a run: its unloaded readings tell, whether or not the robot comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.force_zero.accounts import moved_zeros, without_zeros
from stiffcal.mistakes.force_zero.faults import force_zero_faults, stiffness_bias
from stiffcal.mistakes.force_zero.motion_evidence import likeliest
from stiffcal.mistakes.force_zero.moved_zero import Part, ZeroChange
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.reduction.loads.motion import motion_of
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import cycles_of, joint_springs, played

LARGEST = 400.0  # N
NOISE = Sigma(translation=16e-6, force=0.3, moment=0.05)
RUNS = 4
CHANGED = 2  # number of the run in which the zero moves
WIDTH = 3e-4  # rad of play in three joints: half a millimetre at the tool, a third of the deflection


def robot_with_play(chain: Chain) -> CompliantRobot:
    springs = joint_springs(chain, np.array(SIX_STIFFNESS))
    play = find_effects()["backlash"]
    parts = [PlacedEffect(play, Place("joints", (k,)), {"width": WIDTH, "band": 5.0}) for k in (1, 2, 3)]
    return CompliantRobot(chain, (*springs.placed, *parts))


def loads(rng: np.random.Generator) -> list[Floats]:
    """Return runs of five directions up and down, of which each returns to no load."""
    directions = [np.array(way, dtype=float) for way in ([1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1])]
    return [cycles_of(np.array(directions) + 0.02 * rng.normal(size=(5, 3)), 1, LARGEST) for _ in range(RUNS)]


@pytest.fixture(scope="module")
def states() -> LoadStates:
    """Unloaded are the states 0, 4, 8, … 20 of each run of 21."""
    rng = np.random.default_rng(3)
    return played(robot_with_play(six_axes()), RUNS, wrench=loads(rng), noise=NOISE, full_pose=False, load_scatter=0.02)


def moved(states: LoadStates, zero: Callable[[Floats], Floats], part: Part = Part.FORCE) -> LoadStates:
    """Return the states with a zero, (m, 3) of the parts of the run's time, added to the readings of one run."""
    wrench = states.wrench.copy()
    own = np.flatnonzero(states.run == CHANGED)
    wrench[own, part.columns] += zero(np.linspace(0.0, 1.0, own.size)[:, None])
    return replace(states, wrench=wrench)


def step(at: float, *size: float) -> Callable[[Floats], Floats]:
    return lambda part: np.where(part >= at, np.array(size), 0.0)


@pytest.mark.parametrize(
    ("zero", "kind", "change"),
    [
        (step(0.5, -36.0, 0.0, 0.0), ZeroChange.STEP, (-36.0, 0.0, 0.0)),
        (step(0.1, -36.0, 0.0, 0.0), ZeroChange.STEP, (-36.0, 0.0, 0.0)),
        (step(0.9, 0.0, 8.0, 0.0), ZeroChange.STEP, (0.0, 8.0, 0.0)),
        (step(0.5, 2.5, 0.0, 0.0), ZeroChange.STEP, (2.5, 0.0, 0.0)),  # eight times the noise of a reading
        (step(0.45, 30.0, -90.0, 0.0), ZeroChange.STEP, (30.0, -90.0, 0.0)),
        (step(0.35, 0.0, 0.0, -300.0), ZeroChange.STEP, (0.0, 0.0, -300.0)),
        (lambda part: part * np.array([25.0, 0.0, -15.0]), ZeroChange.DRIFT, (25.0, 0.0, -15.0)),
        (lambda part: part * np.array([0.0, 7.0, 0.0]), ZeroChange.DRIFT, (0.0, 7.0, 0.0)),
        (lambda part: part * np.array([0.0, 130.0, 0.0]), ZeroChange.DRIFT, (0.0, 130.0, 0.0)),
        (lambda part: step(0.3, 0.0, 20.0, 0.0)(part) - step(0.7, 0.0, 20.0, 0.0)(part), ZeroChange.STEPS, (0, 20, 0)),
    ],
)
@pytest.mark.parametrize("timed", [True, False], ids=["logged", "table"])
def test_is_named_though_the_robot_has_play(
    zero: Callable[[Floats], Floats], kind: ZeroChange, change: tuple[float, ...], timed: bool, states: LoadStates
) -> None:
    table = moved(states, zero)
    if not timed:
        unknown = np.full(len(states), np.nan)
        table = replace(table, time=unknown)
    (fault,) = force_zero_faults(table, six_axes())
    assert fault.place == f"run {states.runs[CHANGED].name}"
    assert fault.code is (FaultCode.WRENCH_REZEROED if kind is ZeroChange.STEP else FaultCode.WRENCH_DRIFTED)
    best = [account for accounts in moved_zeros(table) for account in accounts if account.kind is kind]
    assert min(float(np.abs(account.change[:3] - change).max()) for account in best) < 5.0 * 0.3 * np.sqrt(2.0)


@pytest.mark.parametrize(
    ("zero", "kind"),
    [
        (step(0.5, 5.0, 0.0, 0.0), ZeroChange.STEP),
        (step(0.4, 0.0, -60.0, 0.0), ZeroChange.STEP),
        (lambda part: part * np.array([0.0, 0.0, 3.0]), ZeroChange.DRIFT),
        (lambda part: step(0.3, 0.0, 4.0, 0.0)(part) - step(0.7, 0.0, 4.0, 0.0)(part), ZeroChange.STEPS),
    ],
)
def test_is_named_where_the_moments_alone_show_it(
    zero: Callable[[Floats], Floats], kind: ZeroChange, states: LoadStates
) -> None:
    table = moved(states, zero, Part.MOMENT)
    (fault,) = force_zero_faults(table, six_axes())
    assert fault.place == f"run {states.runs[CHANGED].name}"
    assert fault.code is (FaultCode.WRENCH_REZEROED if kind is ZeroChange.STEP else FaultCode.WRENCH_DRIFTED)
    ((account,),) = moved_zeros(table)
    assert (account.part, account.kind) == (Part.MOMENT, kind)
    at = np.linspace(0.0, 1.0, 21)[:, None]
    np.testing.assert_allclose(account.zero[::4, 3:], (zero(at) - zero(at[:1]))[::4], atol=5.0 * 0.05 * np.sqrt(2.0))
    assert not account.zero[:, :3].any()


def test_accounts_of_many_runs_are_weighed_as_each_alone(states: LoadStates) -> None:
    """A run of another length, one with a target that was not seen at times, a step that may have been before."""
    cut = states.select(np.arange(len(states)) < len(states) - 3)
    table = moved(cut, step(0.5, 0.0, 0.0, 250.0))
    for run, size in ((0, 40.0), (1, 80.0), (3, 60.0)):
        table.wrench[np.flatnonzero(table.run == run)[9:], 1] += size
    accounts = [account for of_run in moved_zeros(table) for account in of_run]
    motion = motion_of(table, six_axes(), all_targets=True).measured.copy()
    motion[accounts[0].members[3:5], 1] = np.nan
    together = likeliest(table, accounts, motion)
    assert len({account.members.size for account in accounts}) > 1
    assert any(account.earliest is not None for account in accounts)
    for account, (found, evidence) in zip(accounts, together, strict=True):
        ((alone, evidence_alone),) = likeliest(table, [account], motion)
        assert (found.run, found.between) == (alone.run, alone.between)
        assert evidence == pytest.approx(evidence_alone, rel=1e-9)
    assert len({round(evidence, 6) for _, evidence in together}) == len(accounts)


def test_the_step_lies_between_the_unloaded_states_around_it(states: LoadStates) -> None:
    ((account, *_),) = moved_zeros(moved(states, step(0.5, -36.0, 0.0, 0.0)))
    assert [int(states.row[k]) for k in account.between] == [2 * 21 + 9, 2 * 21 + 13]
    assert account.n_unloaded == 6


def test_nothing_is_said_of_good_runs(states: LoadStates) -> None:
    assert moved_zeros(states) == []
    # nor where a rig leaves a few per cent of each load on, nor of a drift that is less than a sensor's gain
    rng = np.random.default_rng(4)
    left_on = states.wrench.copy()
    left_on[::4, :3] += 0.02 * LARGEST * rng.normal(size=(len(states.wrench[::4]), 3))
    assert moved_zeros(replace(states, wrench=left_on)) == []
    assert moved_zeros(moved(states, lambda part: part * np.array([3.0, 0.0, 0.0]))) == []
    assert moved_zeros(moved(states, lambda part: part * np.array([0.2, 0.0, 0.0]), Part.MOMENT)) == []
    # nor of the last digit of a table
    assert moved_zeros(moved(replace(states, wrench=states.wrench.round(-1)), step(0.5, 0.3, 0.0, 0.0))) == []
    for seed in range(3):
        at_random = LARGEST * np.random.default_rng(seed).normal(size=(len(states), 3))
        at_random[states.reference] = 0.0
        assert force_zero_faults(replace(states, wrench=np.hstack([at_random, 0.0 * at_random])), six_axes()) == []


def test_small_loads_of_random_size_are_no_moved_zeros() -> None:
    """Five states leave the motion of one run no say; those of all runs contradict, but not where a zero did move."""
    rng = np.random.default_rng(7)
    runs = []
    for _ in range(60):
        directions = rng.normal(size=(5, 3))
        forces = LARGEST * rng.uniform(size=(5, 1)) * directions / np.linalg.norm(directions, axis=1)[:, None]
        forces[0] = 0.0
        runs.append(np.hstack([forces, np.zeros((5, 3))]))
    several = [*runs[:CHANGED], loads(rng)[0], *runs[CHANGED:]]
    chain = six_axes()
    springs = joint_springs(chain, np.array(SIX_STIFFNESS))
    states = played(springs, len(several), wrench=several, noise=NOISE, full_pose=False, load_scatter=0.0)
    assert len([accounts for accounts in moved_zeros(states) if not accounts[0].single]) > 5
    assert force_zero_faults(states, chain) == []
    (fault,) = force_zero_faults(moved(states, step(0.5, -36.0, 0.0, 0.0)), chain)
    assert fault.code is FaultCode.WRENCH_REZEROED


def test_a_load_that_stays_on_is_no_zero() -> None:
    """A preload from the third direction on: the robot gives way to it, which no zero makes it do."""
    rng = np.random.default_rng(5)
    preloaded = loads(rng)
    for wrench in preloaded:
        wrench[10:, :3] += [0.0, 0.0, 200.0]
    springs = joint_springs(six_axes(), np.array(SIX_STIFFNESS))
    table = played(springs, RUNS, wrench=preloaded, noise=NOISE, full_pose=False, load_scatter=0.02)
    assert moved_zeros(table)
    assert force_zero_faults(table, six_axes()) == []
    # nor a couple that turns the robot
    rng = np.random.default_rng(5)
    turned = loads(rng)
    for wrench in turned:
        wrench[10:, 3:] += [120.0, 0.0, 0.0]
    table = played(springs, RUNS, wrench=turned, noise=NOISE, full_pose=False, load_scatter=0.02)
    assert moved_zeros(table)
    assert force_zero_faults(table, six_axes()) == []


def test_what_it_does_to_the_stiffness(states: LoadStates) -> None:
    table = moved(states, lambda part: part * np.array([25.0, 0.0, -15.0]))
    accounts = [accounts[0] for accounts in moved_zeros(table)]
    bias = stiffness_bias(table, accounts, six_axes())
    assert bias is not None
    mended = without_zeros(table, accounts)
    np.testing.assert_allclose(mended.wrench, states.wrench, atol=5.0 * 0.3)
    # a fit of the springs on the deformed robot, weighted by the instruments' noise
    fits = [identify_parameters(one, joint_springs(six_axes())) for one in (table, mended)]
    as_read, corrected = (fit.parameters[bias.drive].value for fit in fits)
    assert as_read is not None
    assert corrected is not None
    assert bias.share == pytest.approx(corrected / as_read - 1.0, rel=0.25)
    assert abs(bias.share) > 0.01


def test_two_unloaded_states_are_compared_with_the_sensors_noise(states: LoadStates) -> None:
    few = states.select(np.isin(np.arange(len(states)) % 21, [0, 1, 2, 3, 4]))
    table = replace(few, wrench=few.wrench.copy())
    last = np.flatnonzero(few.run == CHANGED)[-1]
    table.wrench[last, :3] += [0.0, 12.0, 0.0]
    stated = replace(few.setup, sigma=Sigma(force=0.3))
    (fault,) = force_zero_faults(replace(table, setup=stated), six_axes())
    assert fault.place == f"run {states.runs[CHANGED].name}"
    assert force_zero_faults(replace(few, setup=stated), six_axes()) == []
    # of a table that states none, and of which no run has three, nothing is known
    assert moved_zeros(table) == []
