"""Clamped runs of a campaign: from the store's readings to the answer of `identify` for each joint."""

from __future__ import annotations

import hashlib
import pickle
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames import measurement_setup, resolve_frames
from stiffcal.errors import InputError
from stiffcal.experiments.clamped.analysis import ClampedRun, analyse_runs
from stiffcal.experiments.clamped.chain import ClampedChain, clamped_chain
from stiffcal.experiments.clamped.curves import BRANCHES
from stiffcal.experiments.clamped.documents import (
    DEFINITION,
    branches_table,
    clamped_warnings,
    joint_result,
    parameters_of,
    run_result,
    torque_angle,
)
from stiffcal.experiments.clamped.faults import ONE_WAY, loaded_words, run_quality, why_no_sweep
from stiffcal.experiments.clamped.heldout import angle_residual
from stiffcal.experiments.clamped.joints import ClampedJoint, joints_of
from stiffcal.experiments.clamped.readings import ClampedReadings, readings_from_table
from stiffcal.experiments.clamped.reduction import CLAMPED
from stiffcal.experiments.clamped.results import ClampedSection
from stiffcal.experiments.clamped.sweeps import moved_joint
from stiffcal.experiments.measured import MeasuredRuns
from stiffcal.experiments.results import ExperimentFit, ExperimentValidation
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.document import model_summary
from stiffcal.measurements.rms import Rms
from stiffcal.model.assembly import fixed_parameters
from stiffcal.model.campaign_effects import placed_robot
from stiffcal.uncertainty import NORMAL_95
from stiffcal.validation.results import ErrorSlice

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stiffcal.campaign.loading import Campaign
    from stiffcal.campaign.manifest import Run
    from stiffcal.experiments.clamped.heldout import HeldoutRun
    from stiffcal.model.composite import CompliantRobot


_LAST: dict[bytes, ClampedResult] = {}


@dataclass(frozen=True)
class ClampedResult:
    """What the clamped runs of a campaign give."""

    runs: tuple[ClampedRun, ...]
    """The analysed runs, in the campaign's order."""
    joints: tuple[ClampedJoint, ...]
    """The joints that can be identified, from all their runs."""


def clamped_experiment_fit(data: MeasuredRuns) -> ExperimentFit | None:
    """Fit every joint that was driven against the fixture; None where the campaign contains no clamped run.

    Where the campaign holds load states too, these are fitted together with the clamped runs, and the parameters come
    from there; this part then adds play, friction and curve.

    Raises
    ------
    InputError
        A run's moved joint cannot be determined, or its pose is not known.
    """
    result = clamped_result(data.campaign, readings_of(data))
    if result is None:
        return None
    placed = placed_robot(data.campaign).placed
    alone = data.n_states == 0
    parameters, unidentified = parameters_of(placed, result.joints, fixed_parameters(data.campaign.model))
    used = [run for run in result.runs if not run.left_out]
    squares = [run.fit.rms**2 for run in used]
    angles = [angle_residual(run.branches, run.fit.law) for run in used]
    motor_angle = np.concatenate(angles) if angles else np.zeros(0)
    names = data.joint_names
    section = ClampedSection(
        definition=DEFINITION,
        joints=[joint_result(joint, names[joint.joint - 1]) for joint in result.joints],
        runs=[run_result(run) for run in result.runs],
    )
    return ExperimentFit(
        name=CLAMPED,
        section=section,
        parameters=parameters if alone else [],
        not_identifiable=unidentified if alone else [],
        effects=model_summary(placed_robot(data.campaign)).effects if alone else [],
        rms={
            "motor_angle": float(np.sqrt(np.mean(motor_angle**2))) if motor_angle.size else None,
            "torque": float(np.sqrt(np.mean(squares))) if squares else None,
        }
        if alone
        else {},
        noise=_noise_of(result.runs) if alone else {},
        noise_source="repeats" if alone and _noise_of(result.runs) else "none",
        n_runs=len(used),
        n_readings=int(sum(np.count_nonzero(run.sweeps.number >= 0) for run in used)),
        expected=_expected(result) if alone else "",
        warnings=clamped_warnings(data, result.runs, result.joints),
        tables={BRANCHES: branches_table(result.runs)},
    )


def starting_values(data: MeasuredRuns, robot: CompliantRobot) -> dict[str, float]:
    """Return shapes of laws that have no value yet, from each joint's torque over angle.

    Only of laws that no other effect of the joint excludes: a curve that holds its linear term stands for it alone.

    Parameters
    ----------
    data : the campaign, with the table of readings. robot : the model.
    """
    wanted = [placed for placed in robot.placed if placed.place.kind == "joints" and not placed.values]
    readings = readings_of(data) if any(placed.effect.has_curve_of_torque for placed in wanted) else None
    if readings is None:
        return {}
    result = clamped_result(data.campaign, readings)
    joints = {} if result is None else {joint.joint: joint for joint in result.joints}
    values: dict[str, float] = {}
    for placed in wanted:
        joint = joints.get(placed.place.joints[0])
        others = [other.effect.name for other in robot.placed if other is not placed and other.place == placed.place]
        if joint is None or not placed.effect.has_curve_of_torque:
            continue
        known = placed.effect.from_torque_angle(torque_angle(joint), others)
        form = placed.effect.form(known)
        if not {*form.includes, *form.excludes} & set(others):
            values |= {placed.parameter_name(symbol): value for symbol, (value, _) in known.items()}
    return values


def clamped_validation(data: MeasuredRuns) -> ExperimentValidation | None:
    """Judge each joint in a pose that its law was not fitted to.

    None where the campaign contains no clamped run, and where their states are judged like those of other runs.
    """
    from stiffcal.experiments.clamped.heldout import heldout_clamped

    if data.n_states > 0:
        return None
    result = clamped_result(data.campaign, readings_of(data))
    if result is None:
        return None
    heldout = heldout_clamped(result.runs)
    names = data.joint_names
    single = [
        joint.joint for joint in result.joints if joint.joint not in {heldout_run.joint for heldout_run in heldout}
    ]
    warnings = [
        f"joint {names[joint - 1]} was driven in only one usable pose: validation in other poses is not possible"
        for joint in single
    ]
    torque = np.concatenate([heldout_run.torque for heldout_run in heldout]) if heldout else np.zeros(0)
    angle = np.concatenate([heldout_run.angle for heldout_run in heldout]) if heldout else np.zeros(0)
    measured = np.concatenate([heldout_run.measured for heldout_run in heldout]) if heldout else np.zeros(0)
    zero = _rms(measured)
    by_joint = [
        _slice(names[j - 1], [heldout_run for heldout_run in heldout if heldout_run.joint == j])
        for j in sorted({o.joint for o in heldout})
    ]
    return ExperimentValidation(
        name=CLAMPED,
        scheme="leave one pose out, its own middle and zero free" if heldout else "none",
        rms={"torque": _rms(torque), "motor_angle": _rms(angle)},
        max={"torque": _largest(torque), "motor_angle": _largest(angle)},
        noise=_noise_of(result.runs),
        relative={"torque": None if not zero else (_rms(torque) or 0.0) / zero},
        zero_model={"torque": zero},
        by={"run": [_slice(heldout_run.run, [heldout_run]) for heldout_run in heldout], "joint": by_joint},
        section_scheme="leave one pose out",
        n_readings=int(torque.size),
        warnings=warnings,
    )


def _noise_of(runs: Sequence[ClampedRun]) -> dict[str, float | None]:
    """Return the scatter of repeats, N·m of one bin of angle; empty where no branch was gone through twice."""
    squares = [run.branches.noise**2 for run in runs if not run.left_out and run.branches.noise > 0.0]
    return {"torque": float(np.sqrt(np.mean(squares)))} if squares else {}


def _slice(label: str, runs: Sequence[HeldoutRun]) -> ErrorSlice:
    torque = np.concatenate([run.torque for run in runs])
    angle = np.concatenate([run.angle for run in runs])
    nothing: dict[str, float | None] = {"translation": None, "rotation": None}
    return ErrorSlice(
        label=label,
        low=None,
        high=None,
        n=int(torque.size),
        rms=Rms.of(nothing | {"torque": _rms(torque), "motor_angle": _rms(angle)}),
        max=Rms.of(nothing | {"torque": _largest(torque), "motor_angle": _largest(angle)}),
    )


def _rms(values: Floats) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if values.size else None


def _largest(values: Floats) -> float | None:
    return float(np.abs(values).max()) if values.size else None


def _expected(result: ClampedResult) -> str:
    if not result.joints:
        return "no joint can be identified from the clamped runs"
    worst = max(result.joints, key=lambda joint: joint.play_std)
    return f"uncertainty of play: {1e3 * NORMAL_95 * worst.play_std:.2g} mrad or better (95 %)"


def readings_of(data: MeasuredRuns) -> ClampedReadings | None:
    """Return the readings of clamped runs; None where there are none."""
    return data.read(CLAMPED, readings_from_table)


def clamped_result(campaign: Campaign, readings: ClampedReadings | None) -> ClampedResult | None:
    """Analyse a campaign's clamped runs.

    Raises
    ------
    InputError
        A run's moved joint cannot be determined, or its pose is not known.
    """
    if readings is None:
        return None
    written = {run.id: run for run in campaign.manifest.runs}
    readings_of_runs = [readings.of_run(number) for number in range(len(readings.runs))]
    chains = [
        chain_of_run(campaign, run_readings, written.get(info.name))
        for run_readings, info in zip(readings_of_runs, readings.runs, strict=True)
    ]
    # The same readings are asked for at each step of a loop that changes the model alone.
    key = hashlib.blake2b(pickle.dumps((readings_of_runs, chains))).digest()
    if key not in _LAST:
        runs = analyse_runs(readings_of_runs, chains)
        _LAST.clear()
        _LAST[key] = ClampedResult(tuple(runs), tuple(joints_of(runs)))
    return _LAST[key]


def check_clamped_runs(campaign: Campaign, readings_of_runs: Sequence[ClampedReadings]) -> tuple[list[str], list[str]]:
    """Return why runs cannot be used, and what contradicts itself in the others, in words, before anything is fitted.

    Parameters
    ----------
    readings_of_runs : readings, a run each.

    Raises
    ------
    InputError
        A run's moved joint cannot be determined, or its pose is not known.
    """
    unusable, remarks = [], []
    written = {run.id: run for run in campaign.manifest.runs}
    for run_readings in readings_of_runs:
        name = run_readings.runs[int(run_readings.run[0])].name
        chain = chain_of_run(campaign, run_readings, written.get(name))
        quality = run_quality(run_readings, chain)
        if chain.is_excited and quality.one_way:
            unusable.append(f"run {name}: {ONE_WAY}")
        elif chain.is_excited and quality.n_sweeps == 0:
            angle, torque = chain.angle({}), chain.torque[:, chain.joint - 1]
            unusable.append(f"run {name}: {why_no_sweep(angle, torque, quality.saturation)}")
        elif quality.saturation is not None:
            remarks.append(f"run {name}: {quality.saturation.sentence}")
        elif words := loaded_words(name, chain, campaign.chain.joint_names):
            remarks.append(words)
    return unusable, remarks


def chain_of_run(campaign: Campaign, readings: ClampedReadings, run: Run | None) -> ClampedChain:
    """Return a run in drive coordinates, in the pose that the manifest or the log gives.

    Raises
    ------
    InputError
        The moved joint cannot be determined, or the pose is not known.
    """
    chain = campaign.chain
    info = readings.runs[int(readings.run[0])]
    joint = moved_joint(info.name, readings.joints, run.moved_joint if run else None, chain.joint_names)
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    if run is not None and run.joints_deg is not None:
        pose = np.deg2rad(np.array(run.joints_deg))
    else:
        pose = readings.joints.mean(axis=0)
        limits = np.where(np.isfinite(chain.limits), chain.limits, np.array([-4.0, 4.0]) * np.pi)
        beyond = np.flatnonzero((pose < limits[:, 0] - 0.02) | (pose > limits[:, 1] + 0.02))
        if beyond.size and setup.moments_measured:
            k = int(beyond[0])
            raise InputError.at(
                FaultCode.POSE_UNREACHABLE, "campaign.toml", f"run {info.name}: joints_deg",
                f"the log puts {chain.joint_names[k]} at {np.rad2deg(pose[k]):.0f}°, outside its limits: the motor "
        "angles do not determine the pose of the robot",
                "write the pose into the run: joints_deg = [0.0, -30.0, 90.0], say, one per joint",
            )  # fmt: skip
    fixture = None if run is None or run.fixture_compliance is None else np.array(run.fixture_compliance)
    return clamped_chain(readings, joint, chain, setup, pose, fixture)
