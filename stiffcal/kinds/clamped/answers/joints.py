"""What clamped runs give for each joint: its runs brought together, with what they do not determine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.parameters import Parameter, estimated_parameter
from stiffcal.estimation.unknowns import amplitude_bounds
from stiffcal.kinds.clamped.answers.analysis import ClampedRun
from stiffcal.kinds.clamped.held.torque_source import TorqueSource
from stiffcal.kinds.clamped.loops.torque_angle_fit import CURVE
from stiffcal.model.effect import ParameterSpec, Place
from stiffcal.uncertainty import NORMAL_95

# Poses that resolve the play this many times more coarsely than the finest do not count for it.
FINE = 5.0
# Motions that reached less than this share of the largest torque do not count for the curve.
FAR = 0.3
# Torques at which the tangent stiffness is given, as shares of what was reached.
_TANGENTS = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9)


def _spec(symbol: str, unit: str, meaning: str, lower: float = -math.inf) -> ParameterSpec:
    return ParameterSpec(symbol, unit, meaning, lower, math.inf, 0.0, "")


# A description without a model: its numbers are parameters like those of effects, under a name that no effect has.
DESCRIPTION = "torque-over-angle"
SPECS = {
    spec.symbol: spec
    for spec in (
        _spec("low_slope", "rad", "length of the segment of low slope", 0.0),
        _spec("width", "rad", "b of the law", 0.0),
        _spec("friction", "N·m", "half the torque between the branches"),
        _spec("chord", "N·m/rad", "torque over angle from end to end of what was reached", 0.0),
        _spec("tangent", "N·m/rad", "slope of the curve at a torque", 0.0),
        _spec("p1", "N·m/rad", "slope of the curve at the flank"),
        _spec("p2", "N·m/rad²", "its quadratic term"),
        _spec("p3", "N·m/rad³", "its cubic term"),
    )
}


@dataclass(frozen=True)
class CurveSlope:
    """The slope of the curve at a torque."""

    torque: float
    """N·m."""
    angle: float
    """rad, from the flank."""
    stiffness: Parameter
    """N·m/rad."""


@dataclass(frozen=True)
class ClampedJoint:
    """One joint, from all poses in which it was driven."""

    joint: int
    """From 1."""
    runs: tuple[ClampedRun, ...]
    """The runs that are used."""
    left_out: tuple[ClampedRun, ...]
    """The other runs, each with its reason."""
    play: Parameter
    """rad, mean over poses, 0 where none is found; by the scatter between poses and cycles, and half the resolution."""
    width: Parameter
    """rad, b of the law."""
    friction: Parameter | None
    """N·m, half the torque between the branches; None where none is found."""
    curve: tuple[Parameter, Parameter, Parameter]
    """p1, p2, p3, N·m/rad, N·m/rad², N·m/rad³."""
    covariance: Floats
    """(3, 3) of ``curve``."""
    spread: float
    """rad, largest less smallest play of the poses; NaN with one."""
    resolution: float
    """rad, what the play is known to at best."""
    reversal: float | None
    """rad, raw width at zero torque, mean over poses; None where the branches do not come there."""
    reach: tuple[float, float]
    """rad, spring angles that were reached from the flanks, negative and positive side."""
    torque: tuple[float, float]
    """N·m, smallest and largest spring torque that was reached."""
    source: TorqueSource
    """"force sensor" or "motor torque"."""
    curve_runs: tuple[ClampedRun, ...]
    """The used runs that reached enough torque for the curve."""

    @property
    def play_found(self) -> bool:
        """True where there is a play."""
        return bool(self.play.value)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All that was found."""
        return (self.play, self.width, *(() if self.friction is None else (self.friction,)), *self.curve, self.chord)

    @property
    def coefficients(self) -> Floats:
        """(3,) the values of ``curve``."""
        return np.array([one.value for one in self.curve], dtype=np.float64)

    @property
    def chord(self) -> Parameter:
        """Torque over angle from end to end of what was reached, N·m/rad."""
        low, high = self.reach
        powers = np.array([1.0, high + low, high * high + high * low + low * low])
        return self._of_curve("chord", (self.torque[1] - self.torque[0]) / max(high - low, 1e-300), powers)

    def tangents(self) -> list[CurveSlope]:
        """Return the slope of the curve at some torques of those that were reached."""
        angle = np.linspace(*self.reach, 801)
        torque = np.maximum.accumulate(np.stack([angle, angle**2, angle**3], axis=1) @ self.coefficients)
        tangents = []
        for share in _TANGENTS:
            wanted = share * (self.torque[1] if share > 0.0 else -self.torque[0])
            x = float(np.interp(wanted, torque, angle)) if share else 0.0
            slope = np.array([1.0, 2.0 * x, 3.0 * x * x])
            tangents.append(
                CurveSlope(float(wanted), x, self._of_curve("tangent", float(slope @ self.coefficients), slope))
            )
        return tangents

    def _of_curve(self, symbol: str, value: float, powers: Floats) -> Parameter:
        """Return a number that follows from the curve, by its derivatives (3,); at a limit where the curve is."""
        std = math.sqrt(max(float(powers @ self.covariance @ powers), 0.0))
        at_limit = self.curve[0].at_bound
        return described(self.joint, symbol, value, std, (at_limit, at_limit))


def described(
    joint: int, symbol: str, value: float, std: float, limits: tuple[bool, bool] = (False, False)
) -> Parameter:
    """Return one number of a joint's description.

    Parameters
    ----------
    joint : from 1. symbol : of `SPECS`. value, std : with its standard uncertainty, SI.
    limits : whether a search for it ended at its lower, and whether at its upper limit.
    """
    spec, place = SPECS[symbol], Place("joints", (joint,))
    least, most = amplitude_bounds(spec)
    bounds = (value if limits[0] else least, value if limits[1] else most)
    name = f"{DESCRIPTION}.{place.label}.{symbol}"
    return estimated_parameter(name, DESCRIPTION, place, spec, value, std, NORMAL_95, bounds)


def joints_of(runs: Sequence[ClampedRun]) -> list[ClampedJoint]:
    """Bring the runs of each joint together; joints without a usable run are left out."""
    joints = []
    for joint in sorted({run.joint for run in runs}):
        joint_runs = tuple(run for run in runs if run.joint == joint)
        used = tuple(run for run in joint_runs if not run.left_out)
        if used:
            joints.append(_joint(joint, used, tuple(run for run in joint_runs if run.left_out)))
    return joints


def _joint(joint: int, runs: tuple[ClampedRun, ...], left_out: tuple[ClampedRun, ...]) -> ClampedJoint:
    # the pose of finest resolution decides whether there is a play, and those of about that resolution determine it
    finest = min(runs, key=lambda run: run.resolution)
    with_play = [run for run in runs if run.fit.play_found and run.resolution < FINE * finest.resolution]
    has_play = finest in with_play or len(with_play) * 2 > len(runs)
    # a motion that reached little torque carries little information on the curve
    most = max(_largest_torque(run) for run in runs)
    curve_runs = tuple(run for run in runs if _largest_torque(run) >= FAR * most)
    plays = np.array([run.play for run in with_play]) if has_play else np.zeros(0)
    resolution = float(np.mean([run.resolution for run in (with_play if has_play else [finest])]))
    within = [run.cycle_spread / np.sqrt(run.sweeps.cycles) for run in with_play if np.isfinite(run.cycle_spread)]
    between = float(np.std(plays, ddof=1) / np.sqrt(plays.size)) if plays.size > 1 else 0.0
    widths = [(run.fit.law.width, run.fit.std("width")) for run in with_play] if has_play else []
    width, width_std = _mean(widths)
    curve, covariance = _pool_curves(curve_runs)
    frictions = [run for run in curve_runs if run.friction_found]
    friction, friction_std = _mean([(run.fit.law.friction, run.fit.std("friction")) for run in frictions])
    reversals = [run.reversal for run in curve_runs if run.reversal is not None]
    reach, ends = _reached(curve, curve_runs)
    middle = 0.5 * resolution
    play_std = float(np.sqrt(between**2 + float(np.mean(np.square(within or [0.0]))) + middle**2))
    width_std = float(np.hypot(width_std, middle))
    if not has_play:
        # where none is found none is excluded that half of the runs agree with
        agreeing = float(np.median([run.fit.most_width for run in runs])) / NORMAL_95
        play_std, width_std = max(play_std, agreeing), max(width_std, agreeing)
    of_play, of_curve = _limits(with_play if has_play else (), "width"), _limits(curve_runs, "p1")
    p1, p2, p3 = (
        described(joint, symbol, value, std, of_curve)
        for symbol, value, std in zip(CURVE, curve, np.sqrt(np.diagonal(covariance)).tolist(), strict=True)
    )
    return ClampedJoint(
        joint=joint,
        runs=runs,
        left_out=left_out,
        play=described(joint, "low_slope", float(plays.mean()) if plays.size else 0.0, play_std, of_play),
        width=described(joint, "width", width, width_std, of_play),
        friction=described(joint, "friction", friction, friction_std, _limits(frictions, "friction"))
        if 2 * len(frictions) > len(curve_runs)
        else None,
        curve=(p1, p2, p3),
        covariance=covariance,
        spread=float(np.ptp(plays)) if plays.size > 1 else float("nan"),
        resolution=resolution,
        reversal=float(np.mean(reversals)) if reversals else None,
        reach=reach,
        torque=ends,
        source=runs[0].chain.source,
        curve_runs=curve_runs,
    )


def _limits(runs: Sequence[ClampedRun], name: str) -> tuple[bool, bool]:
    """Return whether the search for a number ended at its lower, and at its upper limit, in one of the runs."""
    ends = [run.fit.at_limit.get(name, (False, False)) for run in runs]
    return any(low for low, _ in ends), any(high for _, high in ends)


def _reached(
    curve: tuple[float, float, float], runs: Sequence[ClampedRun]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return spring angle and torque, rad and N·m, up to which the curve of all runs is known.

    The runs' angles count from their own flanks. Where one of them has its flank further in, the common curve at its
    last angle would promise a torque that none of them reached: there it ends at the largest that one did.
    """
    angles, torques = [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        farthest = max(sign * run.fit.law.reach[side] for run in runs)
        most = max(
            min(
                sign * float(run.fit.law.spring(np.array([run.fit.law.reach[side]]))[0]),
                float((sign * (run.branches.torque - run.fit.law.zero)).max(initial=0.0)),
            )
            for run in runs
        )
        angle = np.linspace(0.0, farthest, 801)
        torque = np.maximum.accumulate(sign * (np.stack([sign * angle, angle**2, sign * angle**3], 1) @ curve))
        end = farthest if torque[-1] <= most else float(np.interp(most, torque, angle))
        angles.append(sign * end)
        torques.append(sign * min(float(torque[-1]), most))
    return (angles[0], angles[1]), (torques[0], torques[1])


def _largest_torque(run: ClampedRun) -> float:
    """Return the largest torque that a run reached, N·m."""
    return float(np.abs(run.branches.torque).max(initial=0.0))


def _mean(values: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the mean of (value, std) pairs, and its standard uncertainty: the scatter's or the stated one's."""
    if not values:
        return 0.0, 0.0
    numbers = np.array([value for value, _ in values])
    stated = float(np.sqrt(np.sum(np.square([std for _, std in values])))) / len(values)
    scatter = float(np.std(numbers, ddof=1)) / np.sqrt(numbers.size) if numbers.size > 1 else 0.0
    return float(numbers.mean()), max(stated, scatter)


def _pool_curves(runs: Sequence[ClampedRun]) -> tuple[tuple[float, float, float], Floats]:
    """Return the curve from all runs, each with its covariance; their disagreement widens it (Birge's ratio)."""
    curves = np.array([run.fit.law.curve for run in runs])
    # scaled to what was reached, so that the three coefficients have one size
    size = max(max(-run.fit.law.reach[0], run.fit.law.reach[1]) for run in runs)
    unit = np.array([size, size**2, size**3])
    information, target = np.zeros((3, 3)), np.zeros(3)
    inverses = []
    for run, curve in zip(runs, curves, strict=True):
        scaled = run.fit.curve_covariance * unit[:, None] * unit
        floor = 1e-12 * max(float(np.trace(scaled)), 1e-30)
        inverse = np.linalg.inv(scaled + floor * np.eye(3))
        inverses.append(inverse)
        information += inverse
        target += inverse @ (curve * unit)
    covariance = np.linalg.inv(information)
    mean = covariance @ target
    if len(runs) > 1:
        chi2 = sum(float((c * unit - mean) @ i @ (c * unit - mean)) for c, i in zip(curves, inverses, strict=True))
        covariance = covariance * max(1.0, chi2 / (3.0 * (len(runs) - 1)))
    # An encoder's step stretches the angle by its own error, alike in all cycles: no averaging takes that off.
    stretch = float(np.mean([run.encoder_step / np.sqrt(12.0) / max(np.ptp(run.fit.law.reach), 1e-12) for run in runs]))
    covariance = covariance + stretch**2 * np.outer(mean, mean)
    values = mean / unit
    return (float(values[0]), float(values[1]), float(values[2])), covariance / unit[:, None] / unit
