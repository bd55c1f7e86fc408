"""Friction is solved as every other kind of rows is: the minimum, what is open, and speeds left out of the fit."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from stiffcal.arrays import Floats
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.estimation.unknowns import amplitudes
from stiffcal.kinds.friction.answers.documents import identified_friction
from stiffcal.kinds.friction.fitting.heldout import heldout_friction, left_out
from stiffcal.kinds.friction.fitting.identifiability import MotionLack
from stiffcal.kinds.friction.fitting.joint_fits import fit_friction
from stiffcal.kinds.friction.fitting.part_fit import PartFit
from stiffcal.kinds.friction.fitting.source import MotionSource
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, steady_rows
from stiffcal.kinds.friction.logs.runs import reduce_friction
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.joint_strokes import LAW, friction_runs, robot

TRUE = {"coulomb": 50.0, "viscous": 80.0}
JOINT_2 = Place("joints", (2,))
FRICTION = PlacedEffect(LAW, JOINT_2)
LAW_OF_SPEED = built_in_effects()["stribeck"]
STRIBECK = PlacedEffect(LAW_OF_SPEED, JOINT_2)


@functools.cache
def rows(extra: bool = False) -> FrictionRows:
    values = TRUE | ({"stribeck": 40.0, "velocity": 0.15, "exponent": 1.2} if extra else {})
    samples = reduce_friction(friction_runs(values), robot()).samples
    assert samples is not None
    return steady_rows(samples)


@functools.cache
def bent() -> PartFit:
    return PartFit.of(rows(extra=True), (FRICTION, STRIBECK), robot())


def test_the_estimate_is_the_least_sum_of_squares() -> None:
    """Another solver, of all amplitudes and shapes at once, and another way to take weight out, ends there too."""
    fit, made = bent(), rows(extra=True)
    nuisance = np.linalg.svd(made.nuisance / made.sigma[:, None], full_matrices=False)
    basis = nuisance[0][:, nuisance[1] > 1e-7 * nuisance[1][0]]

    def left(values: Floats) -> Floats:
        friction = fit.solved.about(values, fit.space).predicted[0]
        white = (made.torque - friction) / made.sigma
        return np.asarray(white - basis @ (basis.T @ white))

    values = amplitudes(fit.robot, fit.solved.columns)
    low, high = fit.solved.unknowns.lower, fit.solved.unknowns.upper
    other = least_squares(left, values * 1.05, bounds=(low, high), x_scale=values, xtol=1e-12, ftol=1e-14, gtol=1e-12)
    std = np.sqrt(np.diagonal(fit.covariance))
    assert len(values) == 5
    assert np.abs((values - other.x) / std).max() < 0.01
    assert fit.residual @ fit.residual <= 2.0 * other.cost + 1e-4


def test_a_shape_has_the_bounds_of_the_measured_speeds() -> None:
    unknowns = bent().source.unknowns
    velocity = unknowns.names.index("stribeck.j2.velocity")
    assert unknowns.lower[velocity] > 1e-5
    assert unknowns.upper[velocity] <= 2.0


def test_a_shape_at_the_end_of_the_measured_speeds_has_no_uncertainty() -> None:
    """Beyond them it may go on: the interval is open to that side."""
    fit = bent()
    number = fit.source.unknowns.names.index("stribeck.j2.velocity")
    upper = fit.source.unknowns.upper.copy()
    upper[number] = fit.settled.values[number]
    narrow = replace(fit, source=replace(fit.source, unknowns=replace(fit.source.unknowns, upper=upper)))
    before, after = ({one.name: one for one in made.parameters}["stribeck.j2.velocity"] for made in (fit, narrow))
    assert before.std is not None
    assert (after.value, after.std, after.at_bound) == (before.value, None, True)
    assert after.interval is not None
    assert before.interval is not None
    assert after.interval == (before.interval[0], np.inf)


def test_one_way_leaves_friction_open_and_says_so() -> None:
    forward = rows().select(rows().velocity > 0.0)
    (joint,) = fit_friction(forward, (FRICTION,), robot()).joints
    assert set(joint.lacking.values()) == {MotionLack.ONE_DIRECTION}
    assert [one.value for one in joint.parameters] == [None, None]
    assert joint.free == ()


def test_a_shape_that_no_reading_shows_has_the_usual_value_and_is_not_identified() -> None:
    (joint,) = fit_friction(rows(), (FRICTION, STRIBECK), robot()).joints
    assert joint.lacking["stribeck.j2.exponent"] is MotionLack.SHAPE
    answered = {one.name: one for one in identified_friction(joint)}
    assert answered["stribeck.j2.exponent"].value == LAW_OF_SPEED.spec("exponent").typical
    assert {name for name, one in answered.items() if not one.identifiable} == set(joint.lacking)
    # the same questions as of every other parameter
    assert answered["joint-friction.j2.coulomb"].above_noise is True
    assert answered["stribeck.j2.exponent"].above_noise is None


def test_what_a_drift_of_the_speed_alone_shows_is_open() -> None:
    """One way, only 0.02 % of the viscous torque is no constant of its speed: the noise of the log is no friction."""
    forward = rows().select(rows().velocity > 0.0)
    drift = 1.0 + 2e-4 * np.random.default_rng(3).normal(size=len(forward))
    motion = replace(forward.motion, velocity=forward.motion.velocity * drift[forward.row])
    part = PartFit.of(replace(forward, motion=motion), (FRICTION,), robot())
    assert part.unidentified == {"joint-friction.j2.coulomb", "joint-friction.j2.viscous"}


def test_speeds_left_out_are_what_refits_without_them_leave() -> None:
    made = rows()
    part = PartFit.of(made, (FRICTION,), robot())
    found = left_out(part)
    for piece in np.unique(made.piece)[:6]:
        out = made.piece == piece
        # rows held out are judged by the fit of the others
        refit = fit_friction(made.select(~out), (FRICTION,), robot())
        judged = heldout_friction(made, refit, out)
        assert found[out] == pytest.approx(judged.residual[out], abs=1e-8)


def test_with_shapes_speeds_left_out_are_those_of_refits_to_first_order() -> None:
    made = rows(extra=True)
    found = left_out(bent())
    squares = np.zeros(2)
    for piece in np.unique(made.piece):
        out = made.piece == piece
        refit = fit_friction(made.select(~out), (FRICTION, STRIBECK), robot())
        judged = heldout_friction(made, refit, out).residual[out]
        squares += [np.sum(found[out] ** 2), np.sum(judged**2)]
    assert np.sqrt(squares[0]) == pytest.approx(np.sqrt(squares[1]), rel=0.02)


def test_the_constant_of_a_speed_costs_a_degree_of_freedom() -> None:
    """Left out whole, a speed's own weight is estimated on itself."""
    part = PartFit.of(rows(), (FRICTION,), robot())
    piece = part.rows.piece
    folds = [np.flatnonzero(piece == number) for number in np.unique(piece)]
    about_mean = LeaveOut.of(part.linearised(), folds).residual * part.sigma
    residual = left_out(part)
    for fold in folds:
        weight = 1.0 / part.sigma[fold] ** 2
        assert abs(float(weight @ residual[fold])) < 1e-6 * float(weight @ np.abs(residual[fold]))
        assert residual[fold] == pytest.approx(about_mean[fold] * np.sqrt(len(fold) / (len(fold) - 1.0)))


def test_rows_of_unknown_noise_are_weighed_by_what_is_left() -> None:
    """Weights and values stand still together: a fit with these weights stated ends at the same place."""
    made = rows()
    unknown = replace(made, sigma=np.full(len(made), np.nan))
    part = PartFit.of(unknown, (FRICTION,), robot())
    assert part.source.lasting_weights
    assert float(part.residual @ part.residual) == pytest.approx(part.own_rows.dof - 2.0, rel=1e-3)
    stated = replace(made, sigma=part.sigma)
    again = PartFit.of(stated, (FRICTION,), robot())
    std = np.sqrt(np.diagonal(again.covariance))
    assert np.abs(part.settled.values - again.settled.values).max() < 0.01 * std.min()


def test_weights_of_a_source_are_those_of_its_last_rows() -> None:
    source = MotionSource.of(rows(), (FRICTION,), robot())
    reduced, weights = source.reduced(np.array([10.0, 10.0]), None, True)
    assert weights.sums_as(source.first_space)
    assert source.squares(np.array([10.0, 10.0]), reduced, weights) == pytest.approx(
        reduced.cost(np.zeros(2)), rel=1e-9
    )
