"""Clamped joints in poses that their law was not fitted to: one pose left out, judged by the others' law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import no_progress
from stiffcal.estimation.solve import settle
from stiffcal.estimation.unknowns import Unknowns
from stiffcal.experiments.clamped.analysis import ClampedRun
from stiffcal.experiments.clamped.branch_source import BranchSource
from stiffcal.experiments.clamped.branches import Branches
from stiffcal.experiments.clamped.joints import joints_of
from stiffcal.experiments.clamped.torque_angle import TorqueAngleLaw


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
    """Return the law with middle and zero fitted to branches.

    Without play the zero stays, as in `fit_series`: of a straight spring middle and zero do the same.
    """
    low, high = float(data.angle.min()), float(data.angle.max())
    half, free = 0.5 * law.width, [0, 3] if law.width > 0.0 else [0]
    # steps in units of the range and of the largest torque, from where the law is
    units = np.array([max(high - low, 1e-12), max(float(np.abs(data.torque).max()), 1e-12)])[: len(free)]

    def law_at(steps: Floats) -> TorqueAngleLaw:
        middle, zero = np.append(steps * units, 0.0)[:2] + np.array([law.middle, law.zero])
        reach = (min(low - middle + half, 0.0), max(high - middle - half, 0.0))
        return replace(law, middle=float(middle), zero=float(zero), reach=reach)

    def slopes_at(steps: Floats) -> Floats:
        return np.asarray(law_at(steps).slopes(data.angle, data.up)[:, free] * units)

    source = BranchSource(data, Unknowns.plain(("middle", "zero")[: len(free)]), law_at, slopes_at)
    return law_at(settle(source, np.zeros(len(free)), None, no_progress).values)


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
