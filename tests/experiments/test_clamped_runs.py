"""Clamped joints in poses that their law does not know: one pose left out, the law of the others held against it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation import solve
from stiffcal.experiments.clamped.analysis import ClampedRun
from stiffcal.experiments.clamped.branches import Branches
from stiffcal.experiments.clamped.heldout import HeldoutRun, angle_residual, heldout_clamped
from stiffcal.experiments.clamped.sweeps import Sweeps
from stiffcal.experiments.clamped.torque_angle import TorqueAngleLaw, play_segment
from stiffcal.experiments.clamped.torque_angle_fit import fit_series
from tests.laboratory.torque_angle_laws import DEGREE, ENCODER, branches, clamped_law

NOTHING = Branches(*(np.zeros(0),) * 2, np.zeros(0, dtype=np.bool_), np.zeros(0), np.zeros(0, dtype=np.int64), 0.0)


def clamped_run(
    name: str, law: TorqueAngleLaw, seed: int = 1, noise: float = 0.5, joint: int = 3, **changed: Any
) -> ClampedRun:
    """Return a run of one joint whose sweeps follow a law."""
    data = branches(law, noise, seed)
    fit = fit_series(data)
    chain: Any = SimpleNamespace(source="force sensor")
    run = ClampedRun(
        name=name, joint=joint, holdout=False, chain=chain,
        sweeps=Sweeps(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_), 6), branches=data, fit=fit,
        segment=play_segment(fit.law) if fit.play_found else None, cycle_spread=float("nan"),
        motion=float(np.ptp(data.angle)), encoder_step=ENCODER, resolution=ENCODER, reversal=None, saturation=None,
        others_share=0.0,
    )  # fmt: skip
    return replace(run, **changed)


def held_out(run: ClampedRun) -> ClampedRun:
    return replace(run, holdout=True, left_out="held out")


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def stiffer(law: TorqueAngleLaw, times: float) -> TorqueAngleLaw:
    p1, p2, p3 = law.curve
    return replace(law, curve=(times * p1, times * p2, times * p3))


def slope_of_residual(result: HeldoutRun) -> float:
    """Return how the residual grows with the measured torque, friction aside."""
    return float(np.polyfit(result.measured, result.torque, 1)[0])


@pytest.fixture(scope="module")
def straight() -> TorqueAngleLaw:
    """A straight spring without play or friction."""
    law = clamped_law(3, width=0.0)[0]
    return replace(law, curve=(law.curve[0], 0.0, 0.0))


@pytest.fixture(scope="module")
def own() -> TorqueAngleLaw:
    """The law of joint 3, with some friction."""
    return clamped_law(3, friction=12.0)[0]


@pytest.fixture(scope="module")
def three(own: TorqueAngleLaw) -> list[ClampedRun]:
    """Three poses of joint 3; in each the play lies elsewhere, and the sensor has another zero."""
    return [
        clamped_run(name, replace(own, middle=middle, zero=zero), seed)
        for seed, (name, middle, zero) in enumerate(
            [("a", 0.0, 0.0), ("b", 0.3 * DEGREE, -25.0), ("c", -0.2 * DEGREE, 40.0)], start=1
        )
    ]


def test_poses_of_one_law_leave_noise(three: list[ClampedRun]) -> None:
    """Where the play lies and the sensor's zero are each pose's own: other values of them are no error."""
    judged = heldout_clamped(three)
    assert [run.run for run in judged] == ["a", "b", "c"]
    for result, run in zip(judged, three, strict=True):
        assert result.joint == 3
        np.testing.assert_array_equal(result.measured, run.branches.torque)
        # an encoder's step on the slope, and what two poses know of the curve
        noise = np.hypot(run.branches.noise, ENCODER * run.fit.law.curve[0] / np.sqrt(12.0))
        assert rms(result.torque) < 2.0 * noise
        assert rms(result.angle) < 2.0 * ENCODER


def test_a_stiffer_pose_is_off_by_what_it_is_stiffer(straight: TorqueAngleLaw) -> None:
    """A slope that is 20 % up shows as a sixth of the torque that is measured."""
    stiff = clamped_run("stiff", stiffer(straight, 1.2), 3)
    soft = [clamped_run(name, straight, seed) for seed, name in enumerate("ab", start=1)]
    first, second, off = heldout_clamped([*soft, held_out(stiff)])
    assert off.run == "stiff"
    assert slope_of_residual(off) == pytest.approx(1.0 - 1.0 / 1.2, abs=0.005)
    # the same as an angle, as far as the soft law reaches, a little beyond its poses
    assert np.abs(off.angle).max() == pytest.approx(1.04 * straight.reach[1] * (1.0 - 1.0 / 1.2), rel=0.05)
    assert max(rms(first.angle), rms(second.angle)) < 0.1 * rms(off.angle)


def test_another_friction_is_an_error_of_the_torque(own: TorqueAngleLaw) -> None:
    runs = [clamped_run(name, own, seed) for seed, name in enumerate("ab", start=1)]
    rough = clamped_run("rough", replace(own, friction=42.0), 3)
    (off,) = [result for result in heldout_clamped([*runs, held_out(rough)]) if result.run == "rough"]
    up = rough.branches.up
    assert np.mean(off.torque[up]) == pytest.approx(30.0, abs=2.0)
    assert np.mean(off.torque[~up]) == pytest.approx(-30.0, abs=2.0)


def test_a_run_held_out_is_judged_and_judges_none(three: list[ClampedRun], own: TorqueAngleLaw) -> None:
    odd = held_out(clamped_run("odd", stiffer(own, 2.0), 4))
    with_odd = heldout_clamped([*three, odd])
    assert [run.run for run in with_odd] == ["a", "b", "c", "odd"]
    for without, result in zip(heldout_clamped(three), with_odd, strict=False):
        np.testing.assert_array_equal(without.torque, result.torque)


def test_a_run_is_not_judged_by_itself(straight: TorqueAngleLaw) -> None:
    """Each is off by the whole difference, to opposite sides: with a share in the law it would be by less."""
    runs = [clamped_run("soft", straight), clamped_run("stiff", stiffer(straight, 1.2), 2)]
    soft, stiff = heldout_clamped(runs)
    assert slope_of_residual(soft) == pytest.approx(1.0 - 1.2, abs=0.005)
    assert slope_of_residual(stiff) == pytest.approx(1.0 - 1.0 / 1.2, abs=0.005)


def test_nothing_judges_a_joint_with_one_pose(three: list[ClampedRun], own: TorqueAngleLaw) -> None:
    alone = clamped_run("alone", own, joint=4)
    assert [run.run for run in heldout_clamped([alone, *three])] == ["a", "b", "c"]
    assert heldout_clamped([alone]) == []
    assert heldout_clamped([alone, held_out(clamped_run("out", own, 2, joint=5))]) == []


@pytest.mark.parametrize(
    "unfit",
    [
        lambda run: replace(run, left_out="driven one way only"),
        lambda run: held_out(replace(run, branches=NOTHING)),
        lambda run: held_out(replace(run, branches=replace(run.branches, up=np.ones_like(run.branches.up)))),
    ],
    ids=["left out", "held out without a sweep", "held out and driven one way"],
)
def test_runs_that_say_nothing_are_not_judged(
    three: list[ClampedRun], unfit: Callable[[ClampedRun], ClampedRun]
) -> None:
    judged = heldout_clamped([three[0], three[1], unfit(three[2])])
    assert [run.run for run in judged] == ["a", "b"]
    # and they have no share in the law of the others
    for result, without in zip(judged, heldout_clamped(three[:2]), strict=True):
        np.testing.assert_array_equal(result.torque, without.torque)


def test_a_motion_that_reached_little_torque_is_not_judged(three: list[ClampedRun], own: TorqueAngleLaw) -> None:
    small = replace(own, reach=(0.1 * own.reach[0], 0.1 * own.reach[1]))
    judged = heldout_clamped([*three, clamped_run("small", small, 4, noise=0.05)])
    assert [run.run for run in judged] == ["a", "b", "c"]


@pytest.mark.parametrize(("middle", "zero"), [(0.03, 0.0), (-0.03, 0.0), (0.0, 300.0), (0.0, -300.0), (0.02, -150.0)])
def test_middle_and_zero_are_placed_from_wherever_the_steps_begin(
    three: list[ClampedRun], middle: float, zero: float
) -> None:
    law = three[2].fit.law
    lost = replace(law, middle=law.middle + middle * DEGREE, zero=law.zero + zero)
    begun = replace(three[2], fit=replace(three[2].fit, law=lost))
    (expected,) = [result for result in heldout_clamped([*three[:2], held_out(three[2])]) if result.run == "c"]
    (placed,) = [result for result in heldout_clamped([*three[:2], held_out(begun)]) if result.run == "c"]
    assert rms(placed.torque) == pytest.approx(rms(expected.torque), rel=0.02)


def test_steps_that_do_not_settle_leave_the_best(three: list[ClampedRun], monkeypatch: pytest.MonkeyPatch) -> None:
    settled = heldout_clamped(three)
    monkeypatch.setattr(solve, "MAX_STEPS", 3)
    for best, result in zip(heldout_clamped(three), settled, strict=True):
        assert rms(best.torque) == pytest.approx(rms(result.torque), rel=1e-6)


# ---- the residual in angle


def on_the_law(law: TorqueAngleLaw, late: float = 0.0) -> Branches:
    """Return branches exactly on a law, the angle read ``late`` rad more than it is."""
    half = 0.5 * law.width
    angle = np.linspace(law.middle - half + 0.95 * law.reach[0], law.middle + half + 0.95 * law.reach[1], 200)
    angle, up = np.tile(angle, 2), np.repeat([True, False], 200)
    count = np.full(400, 3, dtype=np.int64)
    return Branches(angle + late, law.torque_at(angle, up), up, np.zeros(400), count, 0.0)


@pytest.mark.parametrize(
    "changed",
    [
        {}, {"friction": 12.0}, {"drag": 0.08}, {"friction": 12.0, "drag": 0.08}, {"lag": 0.002 * DEGREE},
        {"middle": 2.0 * DEGREE, "zero": 70.0, "friction": 12.0, "drag": 0.08},
    ],
)  # fmt: skip
def test_an_error_of_the_angle_comes_back(changed: dict[str, float]) -> None:
    """Friction, what of it grows with the load, the sensor's zero and a lag are taken off first."""
    law = clamped_law(3, **changed)[0]
    np.testing.assert_allclose(angle_residual(on_the_law(law), law), 0.0, atol=2e-7)
    late = angle_residual(on_the_law(law, 1e-4), law)
    np.testing.assert_allclose(late, 1e-4, atol=2e-7)


def test_inside_the_play_no_angle_is_held_against_the_torque() -> None:
    law = clamped_law(3, zero=70.0)[0]
    data = on_the_law(law)
    kept = len(angle_residual(data, law))
    flanks = np.abs(data.torque - law.zero) > 3.0 * law.band
    assert kept == int(flanks.sum())
    assert 0 < kept < len(data.angle)
    # noise that is wider than the crossing widens what is left out
    noisy = replace(data, noise=3.0 * law.band)
    assert len(angle_residual(noisy, law)) == int((np.abs(data.torque - law.zero) > 9.0 * law.band).sum())
    # without a play there is nothing to leave out
    straight = replace(law, width=0.0)
    assert len(angle_residual(on_the_law(straight), straight)) == len(data.angle)


def test_torques_beyond_the_law_have_no_angle() -> None:
    law = replace(clamped_law(3)[0], width=0.0)
    data = on_the_law(law)
    beyond = replace(law, reach=(0.5 * law.reach[0], 0.5 * law.reach[1]))
    _, torque = beyond.grid()
    inside = (data.torque > torque[0]) & (data.torque < torque[-1])
    assert 0 < inside.sum() < len(data.torque)
    assert len(angle_residual(data, beyond)) == int(inside.sum())
