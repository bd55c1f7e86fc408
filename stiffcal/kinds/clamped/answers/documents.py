"""Clamped runs in documents and words: parameters, each joint, each run, what a reader must know."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.identification.answers.document import finite
from stiffcal.kinds.clamped.answers.analysis import LEAST_MOTION
from stiffcal.kinds.clamped.answers.results import (
    ClampedRunResult,
    Definition,
    JointResult,
    RunLeftOut,
    SeriesLaw,
    Tangent,
    TorqueOverAngle,
)
from stiffcal.kinds.clamped.held.faults import TOO_SHORT, loaded_words
from stiffcal.kinds.clamped.logs.sweeps import is_too_short
from stiffcal.kinds.clamped.loops.torque_angle import SLOPE_SHARE
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.wording import listing, percent

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.estimation.parameters import Parameter
    from stiffcal.kinds.clamped.answers.analysis import ClampedRun
    from stiffcal.kinds.clamped.answers.joints import ClampedJoint


DEFINITION = Definition(
    low_slope=(
        f"length of the segment around zero torque in which the slope is below {SLOPE_SHARE:g} of the outer slope "
        "(from the flanks to the ends of the measured range), common to both branches; its torque band is given too"
    ),
    friction="half the torque between the branches at all angles",
    reversal_error="width between the branches at zero torque, which friction alone can also cause",
    angle="angle φ = φ_a − φ_m: rotation of the arm relative to the motor, at the joint side; torque: that on the arm",
    curve="τ = p1 φ + p2 φ² + p3 φ³, φ counted from the flank, monotonic over the measured range",
    left_out=f"poses with a total motion below {LEAST_MOTION:g} times the segment of low slope",
    slope_share=SLOPE_SHARE,
)


def joint_result(joint: ClampedJoint, name: str) -> JointResult:
    """Return a joint's entry in the ``clamped`` section."""
    bands = [run.segment.band for run in joint.runs if run.segment is not None and run.fit.play_found]
    p1, p2, p3 = joint.coefficients.tolist()
    friction, chord = joint.friction, joint.chord
    return JointResult(
        joint=joint.joint,
        low_slope_found=joint.play_found,
        low_slope=_value(joint.play),
        low_slope_std=joint.play.std,
        low_slope_interval=_interval(joint.play),
        law_width=_value(joint.width),
        law_width_interval=_interval(joint.width),
        low_slope_band=float(np.mean(bands)) if bands else None,
        resolution=finite(joint.resolution),
        spread_between_poses=finite(joint.spread),
        friction_found=friction is not None,
        friction=None if friction is None else friction.value,
        friction_std=None if friction is None else friction.std,
        reversal_error=joint.reversal,
        torque_from=joint.source,
        curve=TorqueOverAngle(
            p1=p1,
            p2=p2,
            p3=p3,
            covariance=joint.covariance,
            reach=list(joint.reach),
            torque=list(joint.torque),
            runs=[run.name for run in joint.curve_runs],
        ),
        chord_stiffness=_value(chord),
        chord_interval=_interval(chord),
        tangent_stiffness=[
            Tangent(
                torque=tangent.torque,
                angle=tangent.angle,
                stiffness=_value(tangent.stiffness),
                interval=_interval(tangent.stiffness),
            )
            for tangent in joint.tangents()
        ],
        at_bound=_at_bound(joint),
        runs=[run.name for run in joint.runs],
        left_out=[RunLeftOut(run=run.name, why=run.left_out) for run in joint.left_out],
        name=name,
    )


def _at_bound(joint: ClampedJoint) -> list[str]:
    """Return what rests on a search that ended at a limit; that nothing is found is none."""
    return [one.spec.symbol for one in joint.parameters if one.at_bound and one.value]


def _value(parameter: Parameter) -> float:
    return math.nan if parameter.value is None else parameter.value


def _interval(parameter: Parameter) -> list[float | None]:
    return [finite(end) for end in parameter.interval or ()]


def run_result(run: ClampedRun) -> ClampedRunResult:
    """Return a run's entry in the ``clamped`` section."""
    law = run.fit.law
    return ClampedRunResult(
        run=run.name,
        joint=run.joint,
        used=not run.left_out,
        left_out=run.left_out,
        half_sweeps=run.sweeps.count,
        cycles=run.sweeps.cycles,
        motion=run.motion,
        low_slope=run.play if run.branches.angle.size else None,
        low_slope_between_cycles=finite(run.cycle_spread),
        resolution=finite(run.resolution),
        encoder_step=run.encoder_step,
        reversal_error=run.reversal,
        torque_range=[float(run.branches.torque.min(initial=0.0)), float(run.branches.torque.max(initial=0.0))],
        friction=law.friction if run.both_ways else None,
        friction_found=run.friction_found,
        law=SeriesLaw(
            middle=law.middle,
            width=law.width,
            band=law.band,
            zero=law.zero,
            friction=law.friction,
            drag=law.drag,
            lag=law.lag,
            curve=list(law.curve),
            reach=list(law.reach),
        ),
        rms_torque=run.fit.rms,
        noise_torque=run.branches.noise,
        torque_from=run.chain.source,
        lever=finite(run.chain.lever),
        weight=run.chain.weight,
        others_share=run.others_share,
        saturated=None if run.saturation is None else run.saturation.sentence,
    )


def branches_table(runs: tuple[ClampedRun, ...]) -> pa.Table:
    """Return the averaged branches of all runs: angle, torque, direction, spread between cycles, the law's torque."""
    from stiffcal.measurements.columns import table_of

    runs_with_branches = [run for run in runs if run.branches.angle.size]

    def stacked(values: Sequence[NDArray[Any]]) -> NDArray[Any]:
        return np.concatenate(values) if values else np.zeros(0)

    return table_of(
        {
            "run": [run.name for run in runs_with_branches for _ in range(run.branches.angle.size)],
            "joint": stacked([np.full(run.branches.angle.size, run.joint) for run in runs_with_branches]),
            "angle_rad": stacked([run.branches.angle for run in runs_with_branches]),
            "torque_Nm": stacked([run.branches.torque for run in runs_with_branches]),
            "up": stacked([run.branches.up for run in runs_with_branches]),
            "spread_Nm": stacked([run.branches.spread for run in runs_with_branches]),
            "half_sweeps": stacked([run.branches.n_sweeps for run in runs_with_branches]),
            "law_Nm": stacked([_law(run) for run in runs_with_branches]),
            "residual_Nm": stacked([run.branches.torque - _law(run) for run in runs_with_branches]),
        }
    )


def _law(run: ClampedRun) -> NDArray[Any]:
    return run.fit.law.torque_at(run.branches.angle, run.branches.up)


def clamped_warnings(data: MeasuredRuns, runs: tuple[ClampedRun, ...], joints: tuple[ClampedJoint, ...]) -> list[str]:
    """Return the warnings on the numbers, as sentences."""
    texts = []
    names = data.joint_names
    for run in runs:
        if run.left_out and not run.holdout:
            texts.append(f"run {run.name} is not used for joint {names[run.joint - 1]}: {run.left_out}")
        if is_too_short(run.sweeps.number.size, run.sweeps.count + 1):
            texts.append(f"run {run.name}: {TOO_SHORT}")
        if run.saturation is not None and run.branches.angle.size:
            texts.append(f"run {run.name}: {run.saturation.sentence}")
        elif contradiction := loaded_words(run.name, run.chain, names):
            texts.append(contradiction)
        if run.others_share > 0.05:
            texts.append(
                f"run {run.name}: other joints take up {percent(run.others_share)} of the motion of joint "
                f"{names[run.joint - 1]} in this pose; it is subtracted with their own curves"
            )
    if any(run.chain.source == "motor torque" for run in runs):
        texts.append(
            "the torque is measured by the motors only: it includes friction; half the torque between the branches "
            "is reported as friction"
        )
    if any(not run.chain.moments_measured for run in runs):
        texts.append("no moments are measured: the joint torque is the force times its lever arm about the axis")
    for joint in joints:
        if on_bound := _at_bound(joint):
            texts.append(
                f"joint {names[joint.joint - 1]}, torque over angle: {listing(on_bound)} at the limit of what is "
                "searched, without standard uncertainty"
            )
    with_result = {joint.joint for joint in joints}
    for number in sorted({run.joint for run in runs} - with_result):
        texts.append(f"joint {names[number - 1]} cannot be identified: none of its clamped runs can be used")
    return texts
