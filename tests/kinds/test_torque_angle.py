"""Play, friction and curve of one joint from branches whose truth is known (004, Table 2; physics, section 7)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.estimation import solve
from stiffcal.kinds.clamped.answers.analysis import encoder_step
from stiffcal.kinds.clamped.loops.branches import Branches, average_branches, reversal_error
from stiffcal.kinds.clamped.loops.torque_angle import SLOPE_SHARE, TorqueAngleLaw, play_segment
from stiffcal.kinds.clamped.loops.torque_angle_fit import fit_series
from tests.laboratory.torque_angle_laws import DEGREE, ENCODER, TABLE_2, branches, clamped_law, sweep


@pytest.mark.parametrize("joint", TABLE_2)
def test_the_play_ends_where_the_law_has_a_quarter_of_the_outer_slope(joint: int) -> None:
    """By differences of the law over a hundred thousand points about each end."""
    law = clamped_law(joint)[0]
    segment = play_segment(law)
    assert segment is not None
    x = np.linspace(*law.reach, 100_001)
    torque = law.spring(x)
    angle = law.middle + x + 0.5 * law.width * np.tanh(torque / law.band)
    between = 0.5 * (angle[1:] + angle[:-1])
    slope = np.interp([segment.low, segment.high], between, np.diff(torque) / np.diff(angle))
    assert slope == pytest.approx(SLOPE_SHARE * segment.outer_slope, rel=3e-3)


@pytest.mark.parametrize("joint", TABLE_2)
def test_table_2_comes_back(joint: int) -> None:
    law, noise = clamped_law(joint)
    fit = fit_series(branches(law, noise))
    segment = play_segment(fit.law)
    assert fit.play_found
    assert segment is not None
    # the paper's own resolution is 0.01°
    assert abs(fit.law.width - law.width) < 0.002 * DEGREE
    assert abs(segment.length - law.width) < 0.01 * DEGREE
    x = np.linspace(0.95 * law.reach[0], (0.09 if joint == 1 else 0.095) * DEGREE, 31)
    powers = np.stack([x, x**2, x**3])
    spread = np.sqrt(np.einsum("in,ij,jn->n", powers, fit.curve_covariance, powers))
    # an encoder's step is worth this much torque on the slope, whatever the scatter says
    spread = np.hypot(spread, 0.1 * ENCODER * np.abs(law.tangent(x)) + 2e-3 * np.abs(law.spring(x)))
    assert np.all(np.abs(fit.law.spring(x) - law.spring(x)) < 3.5 * spread)
    assert np.all(fit.law.tangent(np.linspace(*fit.law.reach, 101)) > -1e-6 * law.curve[0])


def moved_law(law: TorqueAngleLaw, number: int, step: float) -> TorqueAngleLaw:
    """Return the law with one of the ten numbers of `TorqueAngleLaw.slopes` changed by a step."""
    fields = ("middle", "width", "band", "zero", "friction", "lag", "drag")
    if number >= len(fields):
        curve = list(law.curve)
        curve[number - len(fields)] += step
        return replace(law, curve=(curve[0], curve[1], curve[2]))
    name, value = fields[number], getattr(law, fields[number])
    return replace(law, **{name: value * np.exp(step) if name == "band" else value + step})


@pytest.mark.parametrize("number", range(10))
@pytest.mark.parametrize("joint", TABLE_2)
def test_slopes_are_those_of_the_torque(joint: int, number: int) -> None:
    """Against central differences; both branches, friction that grows with the load, a lag and a zero."""
    law = clamped_law(joint)[0]
    top = float(np.abs(law.spring(np.array(law.reach))).max())
    law = replace(law, zero=0.01 * top, friction=0.05 * top, lag=0.01 * law.width, drag=0.04, band=0.05 * top)
    half = 0.5 * law.width
    angle = np.linspace(law.middle - half + 0.9 * law.reach[0], law.middle + half + 0.9 * law.reach[1], 201)
    up = np.arange(angle.size) % 2 == 0
    slopes = law.slopes(angle, up)[:, number]
    sizes = [law.width, law.width, 1.0, top, top, law.width, 1.0, *np.abs(law.curve)]
    step = 1e-4 * sizes[number]
    after, before = (moved_law(law, number, s).torque_at(angle, up) for s in (step, -step))
    # the torque is interpolated straight between 201 spring angles, so its slope is off by half a piece's bend
    error = (after - before) / (2.0 * step) - slopes
    assert np.sqrt(np.mean(error**2)) < 0.02 * float(np.abs(slopes).max())


@pytest.mark.parametrize(("joint", "seed"), [(1, 102), (1, 107), (4, 107)])
def test_of_eight_readings_a_sweep_the_play_comes_back(joint: int, seed: int) -> None:
    """Starts that lie nearest to the branches as they are lead to seven times the misfit in these."""
    law, noise = clamped_law(joint)
    fit = fit_series(branches(law, noise, seed, n=8))
    assert fit.law.width == pytest.approx(law.width, rel=0.03)


def test_friction_without_play_is_no_play() -> None:
    law, noise = clamped_law(3, width=0.0, friction=12.0)
    data = branches(law, noise)
    fit = fit_series(data)
    assert not fit.play_found
    assert fit.law.width == pytest.approx(0.0, abs=1e-9)
    assert fit.law.friction == pytest.approx(12.0, abs=5 * fit.std("friction"))
    angle, torque, number, up = sweep(law, noise)
    width = reversal_error(angle, torque, number.astype(np.int64), up.astype(np.bool_))
    # what friction alone makes of the raw width at zero torque, F/k either way
    assert width is not None
    assert width == pytest.approx(2.0 * 12.0 / law.curve[0], rel=0.05)


def test_play_without_friction_is_no_friction() -> None:
    law, noise = clamped_law(3)
    fit = fit_series(branches(law, noise))
    assert fit.play_found
    assert abs(fit.law.friction) < 4.0 * fit.std("friction")
    assert abs(fit.law.friction) < 0.005 * np.abs(law.spring(np.array(law.reach))).max()


def test_play_and_friction_side_by_side() -> None:
    law, noise = clamped_law(2, friction=60.0)
    fit = fit_series(branches(law, noise))
    assert fit.law.width == pytest.approx(law.width, abs=0.003 * DEGREE)
    assert fit.law.friction == pytest.approx(60.0, abs=5.0 * fit.std("friction") + 0.5)


def test_a_soft_spring_is_no_play() -> None:
    """A curve that only bends is recognised by its cubic."""
    straight = clamped_law(5)[0].curve[0]
    law = replace(clamped_law(5, width=0.0)[0], curve=(0.45 * straight, 0.0, 2.0 * straight / (0.1 * DEGREE) ** 2))
    assert not fit_series(branches(law, 0.2)).play_found


def test_two_clocks_are_no_friction() -> None:
    """A torque that stays behind is a lag in angle on the flanks, and nothing in the play."""
    law, noise = clamped_law(6, lag=0.001 * DEGREE)
    fit = fit_series(branches(law, noise), with_lag=True)
    assert fit.law.lag == pytest.approx(0.001 * DEGREE, rel=0.2)
    assert abs(fit.law.friction) < 5.0 * fit.std("friction") + 0.02


def test_one_way_shows_no_friction() -> None:
    law, noise = clamped_law(3)
    angle, torque, number, up = sweep(law, noise)
    only = np.where(up > 0.5, number // 2, -1).astype(np.int64)
    fit = fit_series(average_branches(angle, torque, only, up.astype(np.bool_), 120))
    assert fit.std("friction") == 0.0
    assert abs(fit.law.friction) < 1e-3


def test_encoder_step_shows_in_the_values() -> None:
    angle = sweep(*clamped_law(3))[0]
    assert encoder_step(angle) == pytest.approx(ENCODER, rel=1e-6)
    assert encoder_step(np.random.default_rng(1).standard_normal(1000)) == 0.0


def test_a_curve_that_does_not_settle_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """After two steps no law is found, and none is given out as one."""
    angle = np.linspace(-1e-3, 1e-3, 41)
    torque = 1e5 * angle + 3e10 * angle**3
    both = np.concatenate([torque + 4.0, torque - 4.0])
    count = np.full(82, 4, dtype=np.int64)
    loop = Branches(np.tile(angle, 2), both, np.repeat([True, False], 41), np.full(82, 0.1), count, 0.05)
    assert fit_series(loop).settled
    monkeypatch.setattr(solve, "MAX_STEPS", 2)
    with pytest.raises(InputError, match="the fit of torque over angle of a clamped run does not converge"):
        fit_series(loop)


@pytest.mark.parametrize(
    ("joint", "changed"), [(2, {"friction": 60.0}), (3, {"width": 0.0, "friction": 12.0}), (6, {})]
)
def test_the_curve_is_the_one_of_least_misfit(joint: int, changed: dict[str, float]) -> None:
    """Another solver, begun at the fit and at a law that is off, finds none that leaves less."""
    law, noise = clamped_law(joint, **changed)
    data = branches(law, noise)
    fit = fit_series(data)
    own = fit.law
    # of a straight spring middle and zero do the same
    names = ("middle", "friction", "drag", *(("width", "band", "zero") if fit.play_found else ()))
    top = float(np.abs(data.torque).max())
    sizes = (own.reach[1], top, 1.0, own.width, own.band, top)

    def at(steps: Floats) -> TorqueAngleLaw:
        changed = {
            name: getattr(own, name) + step * size for name, step, size in zip(names, steps, sizes, strict=False)
        }
        curve = tuple(np.array(own.curve) * (1.0 + steps[len(names) :]))
        half, middle = 0.5 * float(changed.get("width", 0.0)), changed["middle"]
        reach = (float(data.angle.min()) - middle + half, float(data.angle.max()) - middle - half)
        return replace(own, **changed, curve=curve, reach=reach)

    def left(steps: Floats) -> Floats:
        return np.asarray(at(steps).torque_at(data.angle, data.up) - data.torque)

    for start in (0.0, 2e-3):
        other = least_squares(left, np.full(len(names) + 3, start), x_scale="jac", xtol=1e-12, ftol=1e-12)
        assert fit.rms <= (1.0 + 1e-4) * np.sqrt(2.0 * other.cost / len(data.torque))
