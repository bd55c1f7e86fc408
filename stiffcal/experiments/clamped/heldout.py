"""Clamped joints in poses that their law was not fitted to: one pose left out, judged by the others' law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.experiments.clamped.analysis import ClampedRun
from stiffcal.experiments.clamped.branches import Branches
from stiffcal.experiments.clamped.joints import joints_of
from stiffcal.experiments.clamped.torque_angle import TorqueAngleLaw

SETTLED, MOST_STEPS = 1e-9, 50


@dataclass(frozen=True)
class HeldoutRun:
    """One pose, left out."""

    run: str
    """The run's id."""
    joint: int
    """The driven joint, from 1."""
    measured: Floats
    """(m,) N·m, averaged torque of the branches."""
    torque: Floats
    """(m,) N·m, measured minus expected."""
    angle: Floats
    """(k,) rad, measured minus expected angle at the torques read, outside the play."""


def heldout_clamped(runs: Sequence[ClampedRun]) -> list[HeldoutRun]:
    """Judge every usable run by the law of the joint's other poses; runs held out by the law of all others.

    The middle of the play and the sensor's zero are the pose's own, as the reference of a load run is.
    """
    heldout_runs = []
    usable = {joint.joint: joint.curve_runs for joint in joints_of([run for run in runs if not run.left_out])}
    for run in runs:
        held_out = run.holdout and run.branches.angle.size and run.both_ways
        # what moved too little to determine the curve neither fits nor judges it
        peers = [peer for peer in usable.get(run.joint, ()) if peer is not run]
        used = any(peer is run for peer in usable.get(run.joint, ()))
        if not (used or held_out) or not peers:
            continue
        joint = joints_of(peers)[0]
        run_law = run.fit.law
        friction = joint.friction or 0.0
        expected = replace(
            run_law, width=joint.width, band=joint.band or run_law.band, curve=joint.curve, friction=friction
        )
        law = _fit_middle_and_zero(expected, run.branches)
        residual = run.branches.torque - law.torque_at(run.branches.angle, run.branches.up)
        angle = angle_residual(run.branches, law)
        heldout_runs.append(HeldoutRun(run.name, run.joint, run.branches.torque, np.asarray(residual), angle))
    return heldout_runs


def _fit_middle_and_zero(law: TorqueAngleLaw, data: Branches) -> TorqueAngleLaw:
    """Return the law with middle and zero fitted to branches, by Gauss-Newton steps.

    Without play the zero stays, as in `fit_series`: of a straight spring middle and zero do the same, and steps along
    what changes nothing would lead out of the range in which the curve is known. Ends when a step moves neither by more
    than `SETTLED` of the range. Where a law's corners keep the steps from that, the best of them counts, which makes a
    residual no smaller than it is.
    """
    best, least = law, np.inf
    low, high = float(data.angle.min()), float(data.angle.max())
    for _ in range(MOST_STEPS):
        half = 0.5 * law.width
        law = replace(law, reach=(min(low - law.middle + half, 0.0), max(high - law.middle - half, 0.0)))
        base = law.torque_at(data.angle, data.up)
        squares = float(np.sum((data.torque - base) ** 2))
        best, least = (law, squares) if squares < least else (best, least)
        step = 1e-3 * max(high - low, 1e-12)
        size = 1e-3 * max(float(np.abs(data.torque).max()), 1e-12)
        slope = (replace(law, middle=law.middle + step).torque_at(data.angle, data.up) - base) / step
        lifted = (replace(law, zero=law.zero + size).torque_at(data.angle, data.up) - base) / size
        columns = np.stack([slope * (high - low), lifted if law.width > 0.0 else np.zeros_like(lifted)], axis=1)
        answer, *_ = np.linalg.lstsq(columns, data.torque - base, rcond=1e-6)
        law = replace(law, middle=law.middle + float(answer[0]) * (high - low), zero=law.zero + float(answer[1]))
        if abs(float(answer[0])) <= SETTLED and abs(float(answer[1])) <= SETTLED * 1e3 * size:
            return law
    return best


def angle_residual(data: Branches, law: TorqueAngleLaw) -> Floats:
    """Return (k,) rad: how far the angle is from the law's at the torques read, outside the play.

    Inside the play the torque does not determine the angle.
    """
    grid, torque = law.grid()
    # friction that grows with the load: τ = P ± (F + μ |P|), solved for P on either side
    sign = np.where(data.up, 1.0, -1.0)
    even = data.torque - law.zero - sign * law.friction
    total = law.zero + even / (1.0 + sign * np.sign(even) * law.drag)
    band = 3.0 * max(law.band, data.noise) if law.width > 0.0 else 0.0
    outside = (np.abs(total - law.zero) > band) & (total > torque[0]) & (total < torque[-1])
    lag = np.where(data.up, law.lag, -law.lag)
    return np.asarray((data.angle - lag - np.interp(total, torque, grid))[outside])
