"""Friction from free motion: Coulomb and viscous friction found again."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from stiffcal.kinds.friction.answers.documents import friction_fit_columns
from stiffcal.kinds.friction.fitting.joint_fits import FrictionFit, fit_friction, friction_curve
from stiffcal.kinds.friction.fitting.torque_rows import motion_rows, stacked_rows, steady_rows
from stiffcal.kinds.friction.logs.runs import reduce_friction
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.friction_law import friction_torque
from tests.laboratory.joint_strokes import LAW, friction_runs, robot

TRUE = {"coulomb": 50.0, "viscous": 80.0}
JOINT_2 = PlacedEffect(LAW, Place("joints", (2,)))


def fitted(values: Mapping[str, float], **how: float) -> FrictionFit:
    reduction = reduce_friction(friction_runs(values, **how), robot())  # type: ignore[arg-type]
    assert reduction.samples is not None
    return fit_friction(steady_rows(reduction.samples), (JOINT_2,), robot())


def test_friction_over_speed_is_found_again() -> None:
    fit = fitted(TRUE)
    (joint,) = fit.joints
    for one in joint.parameters:
        assert one.interval is not None
        assert one.value is not None
        assert one.std is not None
        assert abs(one.value - TRUE[one.spec.symbol]) < 3.0 * one.std, one.name
    assert fit.reduced_chi2 is not None
    # the gear ripple of 80 waves a turn is too fine for the means within passes, and counts as noise
    assert 0.2 < fit.reduced_chi2 < 1.3
    # 5 N·m of a sample, over means of one to hundreds of samples
    assert joint.noise is not None
    assert 0.3 < joint.noise < 3.0


def test_weight_does_not_matter() -> None:
    light, heavy = (fitted(TRUE, weight=weight).joints[0].values for weight in (0.0, 900.0))
    for symbol in ("joint-friction.j2.coulomb", "joint-friction.j2.viscous"):
        assert light[symbol] == pytest.approx(heavy[symbol], abs=0.05)


def test_values_of_the_model_file_hold() -> None:
    reduction = reduce_friction(friction_runs(TRUE), robot())
    assert reduction.samples is not None
    placed = PlacedEffect(LAW, Place("joints", (2,)), {"viscous": 75.0})
    fixed = frozenset({"joint-friction.j2.viscous"})
    (joint,) = fit_friction(steady_rows(reduction.samples), (placed,), robot(), fixed).joints
    by_symbol = {one.spec.symbol: one for one in joint.parameters}
    assert by_symbol["viscous"].fixed
    assert by_symbol["viscous"].value == 75.0
    assert not by_symbol["coulomb"].fixed


def test_the_band_holds_the_truth() -> None:
    fit = fitted(TRUE)
    speed = np.linspace(0.02, 2.0, 40)
    torque, std = friction_curve(fit.joints[0], (JOINT_2,), speed)
    assert np.all(np.abs(torque - friction_torque(speed, TRUE)) < 4.0 * std + 1e-3)
    assert std.max() < 1.0


def test_a_joint_that_only_swings_is_modelled() -> None:
    """Never steady: weight and inertia come from the rigid-body model."""
    time = np.arange(0.0, 20.0, 0.005)
    angle = 0.4 * np.sin(2.0 * time) + 0.25 * np.sin(5.3 * time) + 0.2 * np.sin(0.7 * time)
    velocity = 0.8 * np.cos(2.0 * time) + 1.325 * np.cos(5.3 * time) + 0.14 * np.cos(0.7 * time)
    acceleration = -1.6 * np.sin(2.0 * time) - 7.0225 * np.sin(5.3 * time) - 0.098 * np.sin(0.7 * time)
    torque = friction_torque(velocity, TRUE) + 30.0 * acceleration + 400.0 * np.cos(angle)
    runs = friction_runs(TRUE, (0.5,))
    swing = type(runs[0])(runs[0].info, None, time, np.zeros((time.size, 6)), np.zeros((time.size, 6)), None)
    swing.angle[:, 1], swing.torque[:, 1] = angle, torque + np.random.default_rng(2).normal(size=time.size)
    reduction = reduce_friction([swing], robot())
    assert reduction.steady is None
    assert reduction.motion is not None
    assert "modelled" in reduction.warnings[0]
    (joint,) = fit_friction(motion_rows(reduction.motion, robot()), (JOINT_2,), robot()).joints
    assert joint.values["joint-friction.j2.coulomb"] == pytest.approx(50.0, rel=0.02)
    assert joint.values["joint-friction.j2.viscous"] == pytest.approx(80.0, rel=0.02)


def test_rows_of_both_kinds_go_together() -> None:
    samples = reduce_friction(friction_runs(TRUE), robot()).samples
    assert samples is not None
    rows = steady_rows(samples)
    both = stacked_rows([rows, rows])
    assert len(both) == 2 * len(rows)
    assert both.nuisance.shape[1] == 2 * rows.nuisance.shape[1]
    assert not set(both.piece[: len(rows)]) & set(both.piece[len(rows) :])
    np.testing.assert_allclose(both.means(both.motion.velocity), both.velocity)


def test_no_reading_of_a_joint_of_the_model() -> None:
    samples = reduce_friction(friction_runs(TRUE, (0.5, 1.0)), robot()).samples
    assert samples is not None
    with pytest.raises(ValueError, match="no reading"):
        fit_friction(steady_rows(samples), (PlacedEffect(LAW, Place("joints", (5,))),), robot())


def test_a_run_that_never_reached_its_velocity_is_dropped_with_a_word() -> None:
    reduction = reduce_friction(friction_runs(TRUE, (0.5, 1.0, 2.0, 5.0)), robot())
    assert reduction.motion is None
    assert reduction.steady is not None
    assert np.abs(reduction.steady.velocity).max() == pytest.approx(2.0, rel=1e-3)
    assert len(reduction.dropped["5"]) == 6
    (words,) = reduction.warnings
    assert "run 5, joint A2: 6 readings dropped" in words
    assert "no phase of constant velocity" in words


def test_the_picture_of_friction_over_speed_is_without_the_ripple() -> None:
    """What follows the angle is taken off the measured points; measured less fitted stays the residual."""
    ripple = PlacedEffect(built_in_effects()["torque-ripple"], Place("joints", (2,)))
    samples = reduce_friction(friction_runs(TRUE, ripple_order=6.0), robot()).samples
    assert samples is not None
    fit = fit_friction(steady_rows(samples), (JOINT_2, ripple), robot())
    columns = friction_fit_columns(fit, tuple("123456"))
    names = ("friction_measured_Nm", "friction_Nm", "residual_Nm")
    measured, fitted_friction, residual = (np.asarray(columns[name], dtype=np.float64) for name in names)
    np.testing.assert_allclose(measured - fitted_friction, residual, atol=1e-9)
    curve, _ = friction_curve(fit.joints[0], (JOINT_2, ripple), fit.rows.velocity)
    np.testing.assert_allclose(fitted_friction, curve, atol=1e-9)
    assert float(np.abs(np.asarray(columns["beside_Nm"], dtype=np.float64) - fit.nuisance).max()) > 5.0
