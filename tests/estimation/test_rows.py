"""Rows do what kinds of experiments ask of them: stand together, become equations, hold mistakes and correlations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from stiffcal.arrays import Floats
from stiffcal.estimation.groups import GroupNoise
from stiffcal.estimation.prior import Prior
from stiffcal.estimation.rows import ReadingChange, Rows, joined, together
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.estimation.unknowns import OpenBefore, Unknowns
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import Sigma
from tests.laboratory.function_sources import FunctionSource, independent, solved
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played


def linear(
    names: tuple[str, ...], matrix: Floats, measured: Floats, space: GroupNoise, prior: Prior | None = None
) -> Rows:
    """Return one reading a column, matrix @ x, about zero."""
    zero = np.zeros(len(names))
    known = np.zeros((0, len(names) + 1)) if prior is None else prior.rows(zero)
    mask = np.ones((1, len(measured)), dtype=np.bool_)
    predicted = np.zeros((1, len(measured)))
    return Rows(Unknowns.plain(names), zero, matrix.T[:, None], predicted, measured[None], mask, space, known)


def test_two_campaigns_with_one_robot_are_the_rows_of_both() -> None:
    """Springs are shared; each campaign's own third unknown is its own. As one least-squares problem solves them."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(2, 40, 3))
    measured = rng.normal(size=(2, 40))
    one = linear(("j1", "j2", "load a"), first, measured[0], independent(0.5, (1, 40)))
    other = linear(("j2", "load b", "j1"), second, measured[1], independent(2.0, (1, 40)))
    unknowns, values, reduced = together([one, other])
    assert unknowns.names == ("j1", "j2", "load a", "load b")
    whole = np.zeros((80, 4))
    whole[:40, :3], whole[40:, [1, 3, 0]] = first / 0.5, second / 2.0
    wanted = np.concatenate([measured[0] / 0.5, measured[1] / 2.0])
    expected = np.linalg.lstsq(whole, wanted, rcond=None)[0]
    np.testing.assert_allclose(values + reduced.solve(), expected, rtol=1e-9)
    assert reduced.cost(expected) == pytest.approx(np.sum((whole @ expected - wanted) ** 2))
    assert reduced.dof == 80


def test_two_campaigns_of_a_robot_give_what_they_give_as_one() -> None:
    """Of springs about one robot's values: the information of both campaigns adds up."""
    robot = joint_springs(six_axes(), np.array(SIX_STIFFNESS))
    sigma = Sigma(20e-6, 30e-6, 0.5, 0.3)
    fits = [identify_parameters(played(robot, runs=5, noise=sigma, seed=seed), robot) for seed in (1, 2)]
    # about the same values: the first campaign's
    parts = [replace(fit, robot=fits[0].robot).linearised() for fit in fits]
    unknowns, values, reduced = together(parts)
    assert unknowns.names == fits[0].free_names
    alone = [part.reduced() for part in parts]
    information = sum(part.factor.T @ part.factor for part in alone)
    np.testing.assert_allclose(reduced.factor.T @ reduced.factor, information, rtol=1e-9)
    right = sum(part.factor.T @ part.target for part in alone)
    np.testing.assert_allclose(reduced.solve(), np.linalg.solve(information, right), rtol=1e-6)
    # the first is where it settled: alone it moves by less than a hundredth of a standard uncertainty
    assert np.linalg.norm(alone[0].factor @ alone[0].solve()) < 0.01
    np.testing.assert_array_equal(values, parts[0].values)


def test_what_is_known_of_a_shared_unknown_counts_once() -> None:
    rng = np.random.default_rng(8)
    matrix, measured = rng.normal(size=(2, 9, 2)), rng.normal(size=(2, 9))
    prior = Prior.independent(np.array([0.3, 0.8]))
    parts = [
        linear(names, matrix[k], measured[k], independent(1.0, (1, 9)), prior)
        for k, names in enumerate((("j1", "load a"), ("j1", "load b")))
    ]
    _, _, reduced = together(parts)
    whole = np.zeros((18, 3))
    whole[:9, :2], whole[9:, [0, 2]] = matrix
    information = whole.T @ whole + np.diag([1 / 0.3**2, 1 / 0.8**2, 1 / 0.8**2])
    np.testing.assert_allclose(reduced.factor.T @ reduced.factor, information, rtol=1e-9, atol=1e-9)


def test_a_shared_unknown_has_one_value() -> None:
    one = linear(("j1",), np.ones((3, 1)), np.zeros(3), independent(1.0, (1, 3)))
    with pytest.raises(ValueError, match="two values"):
        together([one, replace(one, values=np.ones(1))])


def by_scipy(missed: Callable[[Floats], Floats], start: Floats) -> tuple[Floats, Floats]:
    """Return where scipy's solver ends, and the standard uncertainties there."""
    found = least_squares(missed, start, xtol=1e-14, ftol=1e-14)
    slopes = np.asarray(found.jac, dtype=np.float64)
    return np.asarray(found.x), np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))


def arm(values: Floats, angles: Floats) -> Floats:
    """Return (2, n) where a plane arm of two links ends: lengths, an offset of the second angle."""
    first, second, offset = values
    both = angles[0] + angles[1] + offset
    return np.stack(
        [first * np.cos(angles[0]) + second * np.cos(both), first * np.sin(angles[0]) + second * np.sin(both)]
    )


ARM = np.array([0.7, 0.5, 0.02])
ANGLES = np.random.default_rng(5).uniform(-1.2, 1.2, size=(2, 60))


def test_a_touched_line_is_an_equation_of_places() -> None:
    """The arm touches the line n · x = d, which has two unknowns of its own; scipy's solver ends at the same values."""
    rng = np.random.default_rng(2)
    first = rng.uniform(-0.5, 0.9, size=60)
    true = np.array([*ARM, 0.1, 0.6])

    def missed(values: Floats, angles: Floats) -> Floats:
        x, y = arm(values[:3], angles)
        return np.asarray(np.cos(values[3]) * x + np.sin(values[3]) * y - values[4])

    def elbow(angle: float) -> float:
        return float(by_scipy(lambda b: missed(true, np.array([[angle], b])), np.array([0.4]))[0][0])

    second = np.array([elbow(angle) for angle in first.tolist()])
    angles = np.stack([first, second + rng.normal(0.0, 1e-5, 60)])
    touched = np.abs(missed(true, np.stack([first, second]))) < 1e-6
    angles = angles[:, touched]
    n = int(touched.sum())
    assert n > 40

    # a length is known: touching a line fixes no scale
    prior = Prior.independent(np.array([1e-5, *np.full(4, np.inf)]), np.array([0.7, 0.0, 0.0, 0.0, 0.0]))
    names = ("first", "second", "offset", "turn", "distance")

    def touching(rows: Rows) -> Rows:
        turn, distance = rows.values[3:]
        normal = np.array([np.cos(turn), np.sin(turn)])
        slope = np.zeros((n, 2, n))
        slope[np.arange(n), :, np.arange(n)] = normal
        equations = rows.equations(normal @ rows.predicted, slope, np.full(n, distance), independent(5e-6, (1, n)))
        own = equations.derivative.copy()
        own[3, 0] = np.array([-np.sin(turn), np.cos(turn)]) @ rows.predicted
        own[4, 0] = -1.0
        return replace(equations, derivative=own)

    source = FunctionSource(
        Unknowns.plain(names), lambda values: arm(values[:3], angles), np.full((2, n), np.nan),
        independent(1.0, (2, n)), prior, touching,
    )  # fmt: skip
    start = np.array([0.7, 0.52, 0.0, 0.13, 0.58])
    ended = solved(source, start)
    assert ended.last_step is None
    other, std = by_scipy(lambda v: np.append(missed(v, angles) / 5e-6, (v[0] - 0.7) / 1e-5), start)
    assert (np.abs(ended.values - other) / std).max() < 1e-2


def test_the_length_of_a_ball_bar_is_an_equation_of_two_places() -> None:
    """Lengths between places alone, of which the bar's gives the scale."""
    rng = np.random.default_rng(3)
    pairs = rng.permutation(60).reshape(30, 2)

    def length(places: Floats) -> tuple[Floats, Floats]:
        apart = places[:, pairs[:, 0]] - places[:, pairs[:, 1]]
        size = np.linalg.norm(apart, axis=0)
        slope = np.zeros((30, 2, 60))
        for q, (a, b) in enumerate(pairs):
            slope[q, :, a], slope[q, :, b] = apart[:, q] / size[q], -apart[:, q] / size[q]
        return size, slope

    measured = length(arm(ARM, ANGLES))[0] + rng.normal(0.0, 1e-5, 30)
    source = FunctionSource(
        Unknowns.plain(("first", "second", "offset")), lambda values: arm(values, ANGLES), np.full((2, 60), np.nan),
        independent(1.0, (2, 60)),
        change=lambda rows: rows.equations(*length(rows.predicted), measured, independent(1e-5, (1, 30))),
    )  # fmt: skip
    ended = solved(source, np.array([0.6, 0.6, 0.0]))
    other, std = by_scipy(lambda v: (length(arm(v, ANGLES))[0] - measured) / 1e-5, np.array([0.6, 0.6, 0.0]))
    assert (np.abs(ended.values - other) / std).max() < 1e-2
    assert (np.abs(ended.values - ARM) / std).max() < 4.0


def test_a_prior_has_a_mean_and_a_covariance() -> None:
    """As the normal distribution that both the prior and the readings are makes it (Gelman and others, ch. 14)."""
    rng = np.random.default_rng(4)
    matrix, measured = rng.normal(size=(12, 3)), rng.normal(size=12)
    covariance = np.array([[0.5, 0.3], [0.3, 0.4]])
    prior = Prior(np.array([0, 2]), np.array([1.0, -2.0]), covariance)
    reduced = linear(("a", "b", "c"), matrix, measured, independent(0.7, (1, 12)), prior).reduced()
    precision = np.zeros((3, 3))
    precision[np.ix_([0, 2], [0, 2])] = np.linalg.inv(covariance)
    information = matrix.T @ matrix / 0.7**2 + precision
    expected = np.linalg.solve(information, matrix.T @ measured / 0.7**2 + precision @ [1.0, 0.0, -2.0])
    np.testing.assert_allclose(reduced.solve(), expected, rtol=1e-9)
    np.testing.assert_allclose(reduced.factor.T @ reduced.factor, information, rtol=1e-9)


def test_a_mistake_changes_readings_and_has_unknowns_of_its_own() -> None:
    """A sensor that was zeroed anew after the twentieth reading: what it does is fitted with everything else."""
    rng = np.random.default_rng(6)
    matrix = rng.normal(size=(50, 2))
    after = (np.arange(50) >= 20).astype(float)
    measured = matrix @ [1.0, -0.5] + 3.0 * after + rng.normal(0.0, 0.1, 50)
    prior = Prior.independent(np.array([2.0, np.inf]))
    rows = linear(("a", "b"), matrix, measured, independent(0.1, (1, 50)), prior)
    # about a first guess of its size
    change = ReadingChange(Unknowns.plain(("zero",)), np.array([1.0]), 1.0 * after[None], after[None, None])
    with_it = rows.with_change(change)
    assert with_it.unknowns.names == ("a", "b", "zero")
    found = with_it.values + with_it.reduced().solve()
    stack = np.column_stack([matrix, after]) / 0.1
    expected = np.linalg.lstsq(np.vstack([stack, [0.5, 0.0, 0.0]]), np.append(measured / 0.1, 0.0), rcond=None)[0]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert found[2] == pytest.approx(3.0, abs=0.2)


def test_what_a_mistake_cannot_share() -> None:
    rows = linear(("a",), np.ones((3, 1)), np.ones(3), independent(1.0, (1, 3)))
    change = ReadingChange(Unknowns.plain(("a",)), np.zeros(1), np.zeros((1, 3)), np.ones((1, 1, 3)))
    with pytest.raises(ValueError, match="unknowns of its own"):
        rows.with_change(change)


def test_what_is_known_of_the_size_of_a_mistake_is_a_row() -> None:
    rows = linear(("a",), np.array([[1.0], [1.0], [0.0]]), np.array([2.0, 2.0, 4.0]), independent(1.0, (1, 3)))
    size = replace(Unknowns.plain(("off",)), prior=np.array([1.0]))
    change = ReadingChange(size, np.array([1.0]), np.array([[0.0, 0.0, 1.0]]), np.array([[[0.0, 0.0, 1.0]]]))
    found = rows.with_change(change)
    # as well known before, about 0, as the third reading says: half of it
    np.testing.assert_allclose(found.values + found.reduced().solve(), [2.0, 2.0])


def test_what_one_of_two_campaigns_shows_is_open_in_neither() -> None:
    open_before = [OpenBefore().with_causes(names, Undetermined.UNDRIVEN) for names in (("j1", "j2"), ("j2", "j3"))]
    first = Unknowns.plain(("j1", "j2"), open_before=open_before[0])
    second = Unknowns.plain(("j1", "j2", "j3"), open_before=open_before[1])
    assert set(joined(first, second).open_before.causes) == {"j2", "j3"}
    with pytest.raises(ValueError, match="two pairs of bounds"):
        joined(first, Unknowns.plain(("j1",), np.zeros(1)))


@pytest.mark.parametrize("constant", [False, True])
def test_what_was_not_read_is_no_reading(constant: bool) -> None:
    """As if it had never been asked for, correlated as the others are."""
    rng = np.random.default_rng(9)
    within = 0.5 ** np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    matrix, measured, group = rng.normal(size=(12, 2)), rng.normal(size=12), np.repeat([0, 1], 6)
    read = np.ones((1, 12), dtype=np.bool_)
    read[0, [1, 4, 7]] = False
    rows = linear(("a", "b"), matrix, np.where(read[0], measured, np.nan), independent(1.0, (1, 12)))
    space = GroupNoise(group, (within, within), np.full(2, constant), read)
    reduced = replace(rows, mask=read, space=space).reduced()
    kept = read[0]
    fewer = linear(("a", "b"), matrix[kept], measured[kept], independent(1.0, (1, 9)))
    parts = tuple(within[np.ix_(kept[group == g], kept[group == g])] for g in (0, 1))
    less = GroupNoise(group[kept], parts, np.full(2, constant), np.ones((1, 9), dtype=np.bool_))
    expected = replace(fewer, space=less).reduced()
    np.testing.assert_allclose(reduced.solve(), expected.solve(), rtol=1e-9)
    assert reduced.dof == expected.dof == 9 - 2 * constant
    assert reduced.remainder == pytest.approx(expected.remainder)


@pytest.mark.parametrize("constant", [False, True])
def test_readings_of_a_run_are_correlated(constant: bool) -> None:
    """Generalised least squares, with and without a free constant of each run (Seber and Lee 2003, section 3.10)."""
    rng = np.random.default_rng(7)
    runs = np.repeat(np.arange(4), 10)
    within = 0.3 ** np.abs(np.subtract.outer(np.arange(10), np.arange(10)))
    matrix, measured = rng.normal(size=(40, 3)), rng.normal(size=40)
    space = GroupNoise(runs, (within,) * 4, np.full(4, constant), np.ones((1, 40), dtype=np.bool_))
    reduced = linear(("a", "b", "c"), matrix, measured, space).reduced()
    design = np.column_stack([matrix, (runs[:, None] == np.arange(4)).astype(float)]) if constant else matrix
    weight = np.linalg.inv(np.kron(np.eye(4), within))
    information = design.T @ weight @ design
    expected = np.linalg.solve(information, design.T @ weight @ measured)
    np.testing.assert_allclose(reduced.solve(), expected[:3], rtol=1e-9)
    left = measured - design @ expected
    assert reduced.cost(expected[:3]) == pytest.approx(left @ weight @ left)
    assert reduced.dof == 40 - 4 * constant
