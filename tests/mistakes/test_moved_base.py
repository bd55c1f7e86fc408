"""A base that is moved between two rows of absolute places: found between which, and not where there is none."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.special import chdtri
from scipy.stats import binom

from stiffcal.arrays import Floats
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.diagnosis.suspects.find import Suspicion
from stiffcal.diagnosis.suspects.moved_rows import _as_measured, left_of_places, moved_rows
from stiffcal.diagnosis.suspects.words import suspect_of_move
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.mistakes.catalogue.places import moved_base as module
from stiffcal.mistakes.places.mistake import MovedRows
from stiffcal.mistakes.places.steps import Steps
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import placed_frame
from tests.laboratory.absolute_places import SIGMA, TARGET, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

N, ROW = 80, 50
# Of counts: the share of draws that a normal variable has within three standard deviations.
THREE_SIGMA = 0.9973
CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"


@cache
def measured(seed: int, sigma: float = SIGMA) -> LoadStates:
    """Return rows of a robot whose links are off and whose joints give."""
    rng, chain = np.random.default_rng([3, seed]), six_axes()
    errors = [dict(zip(("x", "y", "rx", "ry"), 4e-4 * rng.normal(size=4), strict=True)) for _ in range(6)]
    springs = [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS]
    true = (*on_all_joints(LinkGeometry(), 6, errors), *on_all_joints(JointCompliance(), 6, springs))
    return measured_by(CompliantRobot(chain, true), absolute_states(chain, N, seed), 100 + seed, sigma)


def fitted(states: LoadStates) -> Fit:
    model = (
        placed_frame("tracker", True), placed_frame(TARGET, False),
        *on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6),
    )  # fmt: skip
    return identify_parameters(states, CompliantRobot(six_axes(), model))


def moved_base(fit: Fit, states: LoadStates) -> MovedRows | None:
    found = moved_rows(fit, states)
    return None if found is None else found[1]


def steps_about(fit: Fit, states: LoadStates) -> Steps:
    left = left_of_places(fit, states)
    assert left is not None
    return Steps.of(left)


def found(states: LoadStates, change: Floats, turn: Floats | None = None) -> MovedRows | None:
    """Return the move in rows whose places are changed by (n, 3) m, and turned by a rotation vector from `ROW` on."""
    position = states.position.copy()
    if turn is not None:
        centre = position[ROW:].mean(axis=0)
        position[ROW:] = (position[ROW:] - centre) @ rotation_from_vector(turn).T + centre
    states = replace(states, position=position + change[:, None])
    return moved_base(fitted(states), states)


def from_row_on(shift: tuple[float, float, float]) -> Floats:
    return np.where(np.arange(N)[:, None] >= ROW, shift, 0.0)


def test_a_shift_is_named_with_its_row_and_size() -> None:
    shift = (6e-5, -8e-5, 0.0)
    move = found(measured(1), from_row_on(shift))
    assert move is not None
    assert move.state == ROW
    assert move.between == (ROW - 1, ROW)
    assert not move.or_drift
    # thirty rows after it, known to 20 µm each
    assert move.shift == pytest.approx(shift, abs=5.0 * SIGMA / np.sqrt(N - ROW) + 1e-5)
    assert move.standard_errors > 5.0
    assert np.flatnonzero(move.leave_out).tolist() == list(range(ROW, N))


def test_a_turn_is_one_too() -> None:
    move = found(measured(2), np.zeros((N, 3)), np.array([0.0, 0.0, 1e-4]))
    assert move is not None
    assert abs(move.state - ROW) <= 1
    assert move.turn[2] == pytest.approx(1e-4, abs=3e-5)


def in_two_runs(states: LoadStates, time: Floats) -> LoadStates:
    """Return the states as 40 rows each of the runs a and b, with times of their clocks."""
    half = N // 2
    names = ["a" if k < half else "b" for k in range(N)]
    row = np.arange(N) % half + 1
    runs = tuple(
        RunInfo(f"{name} row {k}", "absolute", of=name, measures=StateMeasure.PLACE)
        for name, k in zip(names, row, strict=True)
    )
    return replace(states, runs=runs, row=row, time=time)


def test_a_move_between_two_runs_is_found_whose_clocks_each_start_at_zero() -> None:
    position = measured(1).position.copy()
    position[N // 2 :] += [6e-5, -8e-5, 0.0]
    states = in_two_runs(replace(measured(1), position=position), 20.0 * (np.arange(float(N)) % (N // 2)))
    move = moved_base(fitted(states), states)
    assert move is not None
    assert (move.state, move.between, move.one_place) == (N // 2, (N // 2 - 1, N // 2), True)
    suspect = suspect_of_move(module.MovedBase(), move, states)
    assert (suspect.between, suspect.between_runs) == ([40, 1], ["a", "b"])
    assert "between rows 40 of run a and 1 of run b: fit only" in suspect.likely
    # where it may as well have drifted, no row is stated as that of a move
    assert suspect.why.startswith("from row 1 of run b on all positions are displaced")
    either = suspect_of_move(module.MovedBase(), replace(move, or_drift=True), states)
    assert "or at once" in either.why
    assert not either.is_left_out
    # the shorter side is left out, but for a drift, which an effect explains from both sides
    assert Suspicion(moved=(module.MovedBase(), move)).keep(states).tolist() == (~move.leave_out).tolist()
    assert Suspicion(moved=(module.MovedBase(), replace(move, or_drift=True))).keep(states).all()


def test_rows_are_in_the_order_of_their_runs_and_of_time_in_each() -> None:
    clock = np.arange(N)[::-1] % (N // 2)
    states = in_two_runs(measured(1), clock.astype(np.float64))
    order = _as_measured(states, np.arange(N))
    assert order.tolist() == [*range(N // 2 - 1, -1, -1), *range(N - 1, N // 2 - 1, -1)]
    # without times the rows are as they stand in the table
    without = in_two_runs(measured(1), np.full(N, np.nan))
    assert _as_measured(without, np.arange(N)).tolist() == list(range(N))


def test_there_is_none_where_nothing_moved() -> None:
    assert [seed for seed in range(1, 11) if found(measured(seed), np.zeros((N, 3))) is not None] == []


def test_a_drift_is_no_move() -> None:
    for seed in (1, 2, 3):
        drift = np.linspace(0.0, 2e-4, N)[:, None] * np.array([1.0, -0.5, 0.3])
        assert found(measured(seed), drift) is None
        settling = 2e-4 * (1.0 - np.exp(-np.arange(N) / 25.0))[:, None] * np.array([0.4, 1.0, -0.2])
        assert found(measured(seed), settling) is None


def model_error(rng: np.random.Generator, alike: float) -> Floats:
    """Return (n, 3) m of an error ten times the noise, rows a share ``alike`` of the one before it."""
    error = 10.0 * SIGMA * rng.standard_normal((N, 3))
    for k in range(1, N):
        error[k] = alike * error[k - 1] + np.sqrt(1.0 - alike**2) * error[k]
    return error


def test_errors_that_neighbouring_rows_share_are_no_move() -> None:
    """Rows of a path through the workspace: the model's error changes slowly along it."""
    for seed in range(1, 11):
        assert found(measured(1), model_error(np.random.default_rng([7, seed]), 0.9)) is None


def test_a_move_is_found_next_to_an_error_of_the_model() -> None:
    """Rows in poses that follow no order: neighbours share nothing, and nothing is taken off."""
    for seed in (1, 2, 3):
        change = model_error(np.random.default_rng([7, seed]), 0.0) + from_row_on((8e-4, -8e-4, 4e-4))
        move = found(measured(1), change)
        assert move is not None
        assert abs(move.state - ROW) <= 1
        assert move.standard_errors > 5.0


def test_the_diagnosis_judges_the_longer_side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module.MovedBase, "rows_in_words", lambda _, count: f"<{count}>", raising=False)
    folder = Path(shutil.copytree(CAMPAIGN, tmp_path / "moved", ignore=shutil.ignore_patterns("store")))
    file = folder / "raw" / "poses.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    column = head.split(",").index("X1")
    for k in range(ROW, len(rows)):
        cells = rows[k].split(",")
        cells[column] = f"{float(cells[column]) + 0.3:.6f}"
        rows[k] = ",".join(cells)
    file.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    diagnosis = diagnose_campaign(folder)
    assert diagnosis.missing == []
    (suspect,) = diagnosis.suspects or []
    assert (suspect.run, suspect.row) == ("poses", ROW + 1)
    assert f"rows = {list(range(ROW + 1, len(rows) + 1))}" in suspect.exclude
    # with them the model does not suffice, and no effect of the catalogue accounts for a move
    assert diagnosis.with_suspects is not None
    assert diagnosis.with_suspects.missing == []
    assert diagnosis.with_suspects.unexplained
    assert diagnosis.unexplained is False
    # what is left out is called as the mistake says
    assert f"<{len(rows) - ROW}>" in diagnosis.summary


def test_all_rows_are_allowed_for() -> None:
    """The largest of N falls is at most N times as probable by chance as one of them (Bonferroni)."""
    steps = steps_of(1)
    gain = float(chdtri(6, 1e-9))
    assert module._by_chance(steps, gain, 0.01) == pytest.approx(1e-9 * len(steps.looked_at), rel=1e-6)


@cache
def steps_of(seed: int) -> Steps:
    states = measured(seed)
    return steps_about(fitted(states), states)


def gains_of_noise(count: int) -> Floats:
    """Return (N, count) gains of draws that are not those of the module."""
    steps = steps_of(1)
    return steps.gains(np.random.default_rng(17).standard_normal((*steps.own.shape[:2], count)))[0]


def test_the_limit_is_one_in_a_hundred_of_what_noise_does() -> None:
    """The largest gain of noise exceeds the limit in 1 % of draws, and Bonferroni's limit in far fewer."""
    count = 2000
    largest = np.sort(gains_of_noise(count).max(axis=0))
    # binomial: of 2000 at 1 % twenty exceed it, 8 to 36 at three standard deviations of both samples
    above, below = largest[count - 9], largest[count - 36]
    assert module._by_chance(steps_of(1), float(above) + 1.0, 0.01) is not None
    assert module._by_chance(steps_of(1), float(below), 0.01) is None
    # at 1 % by Bonferroni noise exceeds the limit three times more rarely
    assert np.count_nonzero(largest > chdtri(6, 0.01 / len(steps_of(1).looked_at))) < 0.6 * 0.01 * count


def drawn_motion(size: float, row: int, rng: np.random.Generator) -> Floats:
    """Return (6,) a motion from a row on in a random direction, in standard errors of what the rows show of it."""
    direction = rng.standard_normal(6)
    return np.asarray(
        np.linalg.cholesky(steps_of(1).inverse[row]) @ direction * size / np.linalg.norm(direction), dtype=np.float64
    )


def test_the_range_holds_the_row() -> None:
    """Moves of seven standard errors are in the range in nineteen of twenty draws; the likeliest row in one of two."""
    steps, held, exact, count = steps_of(1), 0, 0, 200
    for seed in range(count):
        rng, row = np.random.default_rng([5, seed]), 8 + seed * (N - 16) // count
        left = rng.standard_normal(steps.own.shape[:2]) + steps.step(row) @ drawn_motion(7.0, row, rng)
        gain = steps.gains(left[:, :, None])[0][steps.looked_at, 0]
        low, high = module._range(module._evidence(gain, 6, float(gain.max()) / 6.0 - 1.0))
        held += int(steps.looked_at[low] <= row <= steps.looked_at[high])
        exact += int(steps.looked_at[np.argmax(gain)] == row)
    assert held >= binom.interval(THREE_SIGMA, count, 0.95)[0]
    least, most = binom.interval(THREE_SIGMA, count, 0.5)
    assert least <= exact <= most


def found_at(size: float, seed: int) -> tuple[int, MovedRows | None]:
    """Return the row, and what is found of a move of so many standard errors in the places themselves.

    The robot is one and the same, so that its standard errors are; the noise is another one.
    """
    states, rng = measured(1), np.random.default_rng([6, seed])
    row = int(rng.integers(8, N - 8))
    motion, centre = drawn_motion(size, row, rng), states.position.mean(axis=(0, 1))
    position = measured(1, 0.0).position + SIGMA * rng.standard_normal(states.position.shape)
    position[row:] = (position[row:] - centre) @ rotation_from_vector(motion[3:]).T + centre + motion[:3]
    moved = replace(states, position=position)
    return row, moved_base(fitted(moved), moved)


@pytest.mark.practice
def test_moves_of_seven_standard_errors_are_found() -> None:
    """In 0.98 of linearised draws; a limit that such a move has to exceed any drift by would find 0.81."""
    count = 20
    moves = [found_at(7.0, seed) for seed in range(count)]
    named = [(row, move) for row, move in moves if move is not None]
    assert len(named) >= binom.interval(THREE_SIGMA, count, 0.98)[0]
    in_range = sum(move.between[0] < row <= move.between[1] for row, move in named)
    assert in_range >= binom.interval(THREE_SIGMA, len(named), 0.95)[0]
    # of 48 such draws 29 could be no drift
    low, high = binom.interval(THREE_SIGMA, len(named), 0.6)
    assert low <= sum(not move.or_drift for _, move in named) <= high


@pytest.mark.practice
def test_a_small_drift_is_never_a_move_beyond_doubt() -> None:
    for seed in range(1, 11):
        drift = 4e-5 * np.linspace(0.0, 1.0, N)[:, None] * np.random.default_rng([8, seed]).standard_normal(3)
        move = found(measured(1), drift)
        assert move is None or move.or_drift


def test_targets_of_a_row_share_errors_of_the_model() -> None:
    """Of nine readings that are all off alike in a row a shift's sum scatters nine times as much as one's alone."""
    rng = np.random.default_rng(3)
    alike = np.repeat(rng.standard_normal((1, 400)), 9, axis=0)
    assert module._shared_in_rows(alike, np.ones_like(alike)) == pytest.approx(9.0, rel=4.0 * np.sqrt(2.0 / 400))
    independent = rng.standard_normal((9, 400))
    assert module._shared_in_rows(independent, np.ones_like(alike)) == pytest.approx(1.0, rel=4.0 * np.sqrt(2.0 / 400))


def test_one_row_that_is_off_is_no_move() -> None:
    """A row off by 0.4 mm near the end is a mistake in it, whatever motion of the last rows it would show."""
    for row in (N - 6, N - 3, 5):
        change = np.zeros((N, 3))
        change[row] = (3e-4, -2e-4, 1e-4)
        assert found(measured(1), change) is None
