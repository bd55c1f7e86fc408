"""What a fit makes of exact data, of too little data, and of data with a fault."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem, identify_parameters
from stiffcal.measurements.load_states import Sigma
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import cycles_of, joint_springs, medium_robot, played

TRACKER = Sigma(translation=16e-6, rotation=30e-6)


def compliances(fit: Fit) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the estimates, NaN where not identifiable."""
    return np.array([np.nan if one.value is None else one.value for one in fit.parameters])


@pytest.mark.parametrize("full_pose", [True, False])
def test_exact_data_give_back_the_compliances(full_pose: bool) -> None:
    """Noise-free, the balanced fit errs by no more than its own stopping rule (a few nm at the target)."""
    states = played(medium_robot(), full_pose=full_pose)
    fit = identify_parameters(states, joint_springs(six_axes()))
    assert np.allclose(compliances(fit) * SIX_STIFFNESS, 1.0, atol=2e-5)
    assert np.max(np.abs(fit.residual)) < 2e-8


def test_first_order_alone_is_biased() -> None:
    """The papers' linear form misses 0.05 % and more on the same data: the levers move as the robot bends."""
    states = played(medium_robot())
    linear = identify_parameters(states, joint_springs(six_axes(), deformed=False))
    assert np.max(np.abs(compliances(linear) * SIX_STIFFNESS - 1.0)) > 5e-4


def test_weight_is_part_of_the_balance() -> None:
    """Without link masses the same data give other compliances: the sag turns the levers."""
    states = played(medium_robot())
    light = six_axes()
    light = replace(light, link_mass=np.zeros(6), masses_known=False)
    fit = identify_parameters(states, joint_springs(light))
    assert np.max(np.abs(compliances(fit) * SIX_STIFFNESS - 1.0)) > 2e-4


def test_an_offset_in_a_run_changes_nothing() -> None:
    """A run's reference reading that is off shifts every displacement of the run alike, and is taken out."""
    states = played(medium_robot())
    position = states.position.copy()
    position[states.run == 2] += [3e-4, -2e-4, 1e-4]
    reference = states.reference & (states.run == 4)
    position[reference] += 1e-3  # this reading itself then stands out, but shifts nothing else
    bumped = replace(states, position=position).with_set_aside(reference, SetAsideCode.BUMPED, "bumped")
    fit = identify_parameters(bumped, joint_springs(six_axes()))
    assert np.allclose(compliances(fit) * SIX_STIFFNESS, 1.0, atol=2e-5)


def test_compliances_are_not_negative() -> None:
    """A joint that is rigid in truth is estimated at zero or above, and its interval begins at zero or above."""
    rigid = SIX_STIFFNESS.copy()
    rigid[3] = 1e12
    for seed in range(4):
        states = played(joint_springs(six_axes(), rigid), noise=Sigma(1e-4, 1e-4), seed=seed)
        fit = identify_parameters(states, joint_springs(six_axes()))
        one = fit.parameter("joint-compliance.j4.c")
        assert one.value is not None
        assert one.value >= 0.0
        assert one.interval is not None
        assert one.interval[0] >= 0.0
        if one.at_bound:
            break
    else:
        pytest.fail("no seed put the estimate on its bound")


def test_what_no_load_turns_is_not_identifiable() -> None:
    """With vertical forces through the axis of joint 1 alone, joint 1 is named and has no number."""
    chain = six_axes()
    robot = joint_springs(chain, SIX_STIFFNESS)
    states = played(robot, runs=4)
    # The wrench is turned to the base in such a way that it is vertical: a force in base axes at the tool.
    from stiffcal.measurements.load_states import Attachment

    setup = replace(states.setup, wrench_axes=Attachment(0, np.eye(4)), moments_measured=False)
    wrench = np.concatenate([cycles_of(np.array([[0.0, 0.0, 1.0]])) for _ in range(4)])
    from stiffcal.model.balance.equilibrium import solve_balance

    angles = chain.model_angles(states.joints[np.flatnonzero(states.reference)])
    run = np.repeat(np.arange(4), len(wrench) // 4)
    rest = solve_balance(robot, angles[run], wrench, setup)
    n = len(run)
    few = states.select(np.arange(n))
    few = replace(
        few,
        run=run,
        joints=states.joints[np.flatnonzero(states.reference)][run],
        wrench=wrench,
        position=rest.target_position,
        rotation=rest.target_rotation,
        reference=np.concatenate([[True], np.diff(run) != 0]),
        setup=replace(setup, sigma=TRACKER),
    )
    fit = identify_parameters(few, joint_springs(chain))
    one = fit.parameter("joint-compliance.j1.c")
    assert not one.identifiable
    assert one.value is None
    assert any(one.name in ambiguity.names for ambiguity in fit.ambiguities)
    assert np.isinf(fit.condition)
    # The others are as they are: nothing of joint 1 leaks into them.
    assert fit.parameter("joint-compliance.j2.c").value == pytest.approx(1.0 / SIX_STIFFNESS[1], rel=1e-3)


def test_fixed_parameters_stay() -> None:
    """A fixed parameter keeps its value and has no uncertainty; the others are estimated next to it."""
    states = played(medium_robot())
    robot = joint_springs(six_axes()).with_values({"joint-compliance.j2.c": 1.0 / SIX_STIFFNESS[1]})
    fit = identify_parameters(states, robot, Settings(fixed=frozenset({"joint-compliance.j2.c"})))
    one = fit.parameter("joint-compliance.j2.c")
    assert one.fixed
    assert one.std is None
    assert one.value == 1.0 / SIX_STIFFNESS[1]
    assert np.allclose(compliances(fit) * SIX_STIFFNESS, 1.0, atol=2e-5)


def test_huber_bears_wild_readings() -> None:
    """Ten readings that are off by a millimetre move the least-squares fit far, the Huber fit little."""
    rng = np.random.default_rng(5)
    states = played(medium_robot(), noise=TRACKER, runs=8)
    states = replace(states, setup=replace(states.setup, sigma=TRACKER))
    position = states.position.copy()
    position[rng.choice(len(states), 10, replace=False)] += 1e-3
    bumped = replace(states, position=position)
    error = {}
    for loss in ("linear", "huber"):
        fit = identify_parameters(bumped, joint_springs(six_axes()), Settings(loss=loss))
        error[loss] = float(np.max(np.abs(compliances(fit) * SIX_STIFFNESS - 1.0)))
        # its rows are those of the fit: under their weights it is the minimum
        reduced = fit.linearised().reduced()
        assert np.linalg.norm(reduced.factor @ reduced.solve()) < 0.02
    assert error["huber"] < 0.3 * error["linear"]


def test_intervals_cover_the_truth_in_one_campaign() -> None:
    """χ² of (estimate − truth) under the stated covariance is ordinary: the coverage study judges the rest."""
    noise = Sigma(16e-6, 30e-6, 0.7, 0.2)
    states = played(medium_robot(), noise=noise, runs=8, load_scatter=0.02)
    states = replace(states, setup=replace(states.setup, sigma=noise))
    fit = identify_parameters(states, joint_springs(six_axes()))
    error = compliances(fit) - 1.0 / SIX_STIFFNESS
    chi2 = float(error @ np.linalg.solve(fit.covariance, error))
    assert chi2 < 22.5  # 99.9 % of χ² with six degrees of freedom
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / fit.dof))


def test_hidden_targets_are_no_readings() -> None:
    """Readings without a position are left out, and the rest fits as before."""
    states = played(medium_robot())
    position, rotation = states.position.copy(), states.rotation.copy()
    gone = np.arange(3, len(states), 5)
    position[gone], rotation[gone] = np.nan, np.nan
    problem = fit_problem(replace(states, position=position, rotation=rotation), joint_springs(six_axes()))
    fit = fit_observations(problem, joint_springs(six_axes()), Settings())
    assert np.allclose(compliances(fit) * SIX_STIFFNESS, 1.0, atol=2e-5)
    assert fit.dof < 6 * len(states) - 6 * len(gone)


def test_overlapping_sets_leave_what_explains_the_data() -> None:
    """Six springs in each joint: fourteen cannot be distinguished; those that stand back others can stand for.

    The drive of joint 6 turns about the axis that joint 5's bearing tilts about, and three equal springs of joint 4
    are three equal springs of joint 5: with the wrong ones held at zero, compliances would have to be negative.
    """
    from tests.benchmarks.fit_speed import many_states, springs

    fit = identify_parameters(many_states(1500), springs(six_axes(), True, False))
    assert fit.noise is not None
    assert fit.noise.rotation == pytest.approx(30e-6, rel=0.1)
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    assert 10 <= len(fit.left_at_neutral) <= 16


def test_what_stands_back_leaves_the_others_within_their_bounds() -> None:
    """Forces through one point of the flange see fifteen of a whole compliance's twenty-one numbers.

    Without those of rotation by rotation the rest would need negative ones on the diagonal: others have to stand back.
    """
    upper = np.array(
        [
            [0.32, -0.16, -0.20, 0.40, 0.47, 0.01],
            [0.00, 0.49, 0.29, -1.07, 0.15, -0.15],
            [0.00, 0.00, 0.50, -0.67, -0.02, 0.20],
            [0.00, 0.00, 0.00, 6.70, -1.27, 1.62],
            [0.00, 0.00, 0.00, 0.00, 4.20, -0.51],
            [0.00, 0.00, 0.00, 0.00, 0.00, 0.98],
        ]
    )
    compliance = 6e-7 * (upper + upper.T - np.diag(np.diag(upper)))
    effect, place = find_effects()["joint-full"], Place("joints", (6,))
    values = {f"c{i + 1}{j + 1}": float(compliance[i, j]) for i in range(6) for j in range(i, 6)}
    robot, unknown = medium_robot(), joint_springs(six_axes())
    whole = PlacedEffect(effect, place, values)
    states = played(replace(robot, placed=(*robot.placed, whole)), 12, seed=2, noise=TRACKER)
    fit = identify_parameters(states, replace(unknown, placed=(*unknown.placed, PlacedEffect(effect, place))))
    truth = Settings(fixed=frozenset(whole.parameter_name(symbol) for symbol in values))
    known = identify_parameters(states, replace(unknown, placed=(*unknown.placed, whole)), truth)
    assert fit.reduced_chi2 is not None
    assert known.reduced_chi2 is not None
    # What is best within bounds is no worse than the truth, which lies within them.
    assert fit.reduced_chi2 < 1.01 * known.reduced_chi2


def test_intervals_are_students_where_the_noise_is_not_known() -> None:
    """Twenty readings in a single cycle: the residuals alone show the noise, and t is wider than the normal's 1.96."""
    wrench = [cycles_of(np.eye(3)[:2], cycles=1)]
    states = played(medium_robot(), runs=1, wrench=wrench, noise=Sigma(20e-6, 40e-6), full_pose=False)
    free = Settings(fixed=frozenset(f"joint-compliance.j{k}.c" for k in (3, 4, 5, 6)))
    fit = identify_parameters(states, joint_springs(six_axes(), SIX_STIFFNESS), free)
    assert fit.scaled
    assert 5 < fit.dof < 60
    second = fit.parameter("joint-compliance.j2.c")
    assert second.interval is not None
    assert second.std is not None
    assert np.diff(second.interval)[0] / (2.0 * second.std) == pytest.approx(stdtrit(fit.dof, 0.975), rel=1e-9)
