"""Iterations that miss their convergence test are errors, or the answer says so; rounding decides nothing."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.diagnosis.scans import normal_equations
from stiffcal.diagnosis.scans.choosing import first_least
from stiffcal.errors import InputError
from stiffcal.estimation import bounded_least_squares, solve
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.estimation.identifiability import check_identifiability
from stiffcal.estimation.unknowns import Unknowns, free_columns
from stiffcal.identification.answers import dual_form
from stiffcal.identification.answers.document import fit_warnings
from stiffcal.identification.derivatives import rest_tangent
from stiffcal.identification.derivatives.observation import derivatives
from stiffcal.identification.fitting.identify import Settings, fit_problem, identify_parameters
from stiffcal.identification.noise import variance_components
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.balance.no_balance import NoBalanceError
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


def test_a_fit_that_does_not_settle_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one step allowed, the levers still move: the fit is there, and warns."""
    states = played(medium_robot(), noise=Sigma(15e-6, 2e-5), seed=1)
    whole = identify_parameters(states, joint_springs(six_axes()))
    assert whole.last_step is None
    assert not any("did not converge" in line for line in fit_warnings(whole))
    monkeypatch.setattr(solve, "MAX_STEPS", 1)
    fit = identify_parameters(states, joint_springs(six_axes()), Settings(loss="huber"))
    assert fit.last_step is not None
    assert fit.last_step > solve.SMALL_STEP
    (line,) = [line for line in fit_warnings(fit) if "did not converge" in line]
    assert line.startswith("the fit did not converge in 1 steps: the last one still changed the parameters by ")


def test_the_linear_form_needs_one_step() -> None:
    states = played(medium_robot(), noise=Sigma(15e-6, 2e-5), seed=1)
    assert identify_parameters(states, joint_springs(six_axes(), deformed=False)).last_step is None


def test_columns_that_do_not_settle_are_no_balance(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = medium_robot()
    data = fit_problem(played(truth), truth).data
    columns = free_columns(truth)
    assert np.isfinite(derivatives(truth, data, columns)).all()
    monkeypatch.setattr(rest_tangent, "MAX_SWEEPS", 1)
    monkeypatch.setattr(rest_tangent, "TOLERANCE", 1e-12)  # a first sweep contracts by a hundred
    with pytest.raises(NoBalanceError):
        derivatives(truth, data, columns)


def test_the_dual_form_that_does_not_settle_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    fit = identify_parameters(played(medium_robot(), noise=Sigma(15e-6, 2e-5)), joint_springs(six_axes()))
    monkeypatch.setattr(dual_form, "MAX_STEPS", 1)
    with pytest.raises(
        InputError, match="model.toml: effects: the iteration does not converge: a step of .* remains after 1"
    ):
        dual_form.identify_in_two_forms(fit)


def test_bounded_least_squares_that_do_not_settle_are_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    design, zero = np.eye(4), np.zeros(4)
    wanted = np.array([1.0, -2.0, 3.0, 4.0])
    assert least_squares_within(design, wanted, zero, zero + np.inf)[0].tolist() == [1.0, 0.0, 3.0, 4.0]
    monkeypatch.setattr(bounded_least_squares, "MOST_EXCHANGES", -len(zero))  # as many more come with the unknowns
    with pytest.raises(InputError, match="with 4 unknowns do not converge"):
        least_squares_within(design, wanted, zero, zero + np.inf)
    monkeypatch.setattr(normal_equations, "PIVOTS", 0)
    with pytest.raises(InputError, match="with 4 unknowns do not converge"):
        normal_equations.solve_within(design, wanted, zero, zero + np.inf)


@pytest.mark.parametrize("pivots", [0, 6])
def test_pivots_that_do_not_end_are_left_to_the_active_set(pivots: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The answer is the best within bounds, however far the pivots got."""
    rng = np.random.default_rng(2)
    columns, wanted = rng.normal(size=(20, 40, 5)), rng.normal(size=(20, 40))
    normal, right = np.swapaxes(columns, 1, 2) @ columns, np.einsum("bnk,bn->bk", columns, wanted)
    zero = np.zeros(5)
    monkeypatch.setattr(normal_equations, "PIVOTS", pivots)
    found = normal_equations.solve_within(normal, right, zero, zero + np.inf)
    for design, aim, x in zip(columns, wanted, found, strict=True):
        best, _ = least_squares_within(design, aim, zero, zero + np.inf)
        assert x == pytest.approx(best, rel=1e-8, abs=1e-9)


def repeats() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return scaled differences (c, 6), levers (c, 6, 6) of forces alone, and kinds of rows."""
    rng = np.random.default_rng(3)
    levers = np.zeros((60, 6, 6))
    levers[:, :, :3] = rng.normal(size=(60, 6, 3))
    differences = rng.normal(size=(60, 6)) + 0.5 * np.einsum("cij,cj->ci", levers, rng.normal(size=(60, 6)))
    return differences, levers, np.array([0, 0, 0, 1, 1, 1])


def test_levers_that_are_rounding_are_no_levers() -> None:
    """Moments through the point itself have a lever of 1e-17 on one processor, and none on another."""
    differences, levers, kinds = repeats()
    exact = variance_components.variance_components(differences, levers, kinds)
    assert exact[3] == 0.0
    rounded = levers.copy()
    rounded[:, :, 3:] = 1e-17 * np.random.default_rng(1).normal(size=(60, 6, 3))
    found = variance_components.variance_components(differences, rounded, kinds)
    assert found.tolist() == pytest.approx(exact.tolist(), rel=1e-9)


def test_a_scatter_that_does_not_settle_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(variance_components, "MOST_STEPS", 1)
    with pytest.raises(InputError, match="components of the repeats do not converge in 1 steps; state sigma"):
        variance_components.variance_components(*repeats())


def test_a_direction_that_is_blind_but_for_rounding_has_no_condition() -> None:
    """The last singular value is 1e-17 on one processor and nothing on another: neither is a condition number."""
    factor = np.array([[1.0, 1.0], [0.0, 0.0]])
    for rounding in (0.0, 1e-17, 1e-16):
        factor[1, 1] = rounding
        assert check_identifiability(factor, Unknowns.plain(("a", "b"))).condition == np.inf


def test_a_parameter_that_stands_back_is_never_identifiable() -> None:
    """The first two agree nearly enough that they make the last with more than ten times its own share."""
    factor = np.array(
        [
            [-1.0, -0.999994, -0.999841, -0.996095],
            [0.0, 0.003367, -0.013491, 0.070254],
            [0.0, 0.0, 0.011651, -0.053461],
            [0.0, 0.0, 0.0, 0.000847],
        ]
    )
    checked = check_identifiability(factor, Unknowns.plain(("a", "b", "c", "d")))
    assert checked.left_at_neutral.tolist() == [False, False, True, True]
    assert not checked.identifiable[checked.left_at_neutral].any()
    assert any("d" in ambiguity.names for ambiguity in checked.ambiguities)


@pytest.mark.parametrize("rounding", [-1e-15, 0.0, 1e-15])
def test_the_sign_of_a_known_combination_does_not_depend_on_rounding(rounding: float) -> None:
    factor = np.array([[1.0, 1.0 + rounding], [0.0, 0.0]])
    (found,) = check_identifiability(factor, Unknowns.plain(("a", "b"))).ambiguities
    assert found.coefficients == pytest.approx((1.0, 1.0))
    factor[0, 1] *= -1.0
    (found,) = check_identifiability(factor, Unknowns.plain(("a", "b"))).ambiguities
    assert found.coefficients == pytest.approx((1.0, -1.0))


def test_the_first_of_equal_errors_comes_first_whatever_the_rounding() -> None:
    errors = np.array([[2.0, 3.0], [1.0, 3.0], [1.0 - 1e-15, 3.0 - 1e-14], [1.1, 2.9]])
    assert first_least(errors).tolist() == [1, 3]
