"""Clamped runs of a campaign: from the store's readings to the answer of `identify` for each joint."""

from __future__ import annotations

import hashlib
import pickle
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.errors import InputError
from stiffcal.estimation.parameters import reported_parameters
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.document import identified_parameter, model_summary
from stiffcal.identification.answers.fit_results import UnidentifiedParameters
from stiffcal.kinds.clamped.answers.analysis import ClampedRun, analyse_runs
from stiffcal.kinds.clamped.answers.curves import BRANCHES
from stiffcal.kinds.clamped.answers.documents import (
    DEFINITION,
    branches_table,
    clamped_warnings,
    joint_result,
    run_result,
)
from stiffcal.kinds.clamped.answers.joints import ClampedJoint, joints_of
from stiffcal.kinds.clamped.answers.results import ClampedSection
from stiffcal.kinds.clamped.held.chain import ClampedChain, clamped_chain
from stiffcal.kinds.clamped.held.faults import ONE_WAY, TOO_SHORT, loaded_words, run_quality, why_no_sweep
from stiffcal.kinds.clamped.logs.readings import CLAMPED, ClampedReadings, readings_from_table
from stiffcal.kinds.clamped.logs.sweeps import moved_joint
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.results import ExperimentFit, ExperimentValidation
from stiffcal.model.assembled.assembly import fixed_parameters
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.forms import symbols_of, torque_curve
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stiffcal.campaign.loading import Campaign
    from stiffcal.campaign.manifest.manifest import Run
    from stiffcal.model.assembled.composite import CompliantRobot


WITHOUT_STATES = (
    "no clamped run makes load states: it takes five readings or more in each half sweep, and torques without gaps"
)
_LAST: dict[bytes, ClampedResult] = {}


@dataclass(frozen=True)
class ClampedResult:
    """What the clamped runs of a campaign give."""

    runs: tuple[ClampedRun, ...]
    """The analysed runs, in the campaign's order."""
    joints: tuple[ClampedJoint, ...]
    """The joints that can be identified, from all their runs."""


def clamped_experiment_fit(data: MeasuredRuns) -> ExperimentFit | None:
    """Describe every joint that was driven against the fixture; None where the campaign contains no clamped run.

    The parameters of the model are fitted to the runs' states (`stiffcal.kinds.clamped.states.states`).

    Raises
    ------
    InputError
        A run's moved joint cannot be determined, or its pose is not known.
    """
    result = clamped_result(data.campaign, readings_of(data))
    if result is None:
        return None
    names = data.joint_names
    section = ClampedSection(
        definition=DEFINITION,
        joints=[joint_result(joint, names[joint.joint - 1]) for joint in result.joints],
        runs=[run_result(run) for run in result.runs],
    )
    fit = ExperimentFit(
        name=CLAMPED,
        section=section,
        n_runs=sum(not run.left_out for run in result.runs),
        n_readings=int(sum(np.count_nonzero(run.sweeps.number >= 0) for run in result.runs if not run.left_out)),
        warnings=clamped_warnings(data, result.runs, result.joints),
        tables={BRANCHES: branches_table(result.runs)},
    )
    return fit if data.n_states else _without_states(data, fit)


def _without_states(data: MeasuredRuns, fit: ExperimentFit) -> ExperimentFit:
    """Return what clamped runs without a load state add: no parameter of the model is identified, and why."""
    robot = placed_robot(data.campaign)
    parameters = reported_parameters(robot, {}, NORMAL_95, fixed_parameters(data.campaign.model))
    unknown = [parameter.name for parameter in parameters if not parameter.identifiable]
    group = UnidentifiedParameters(parameters=unknown, known=None, reason=WITHOUT_STATES)
    return replace(
        fit,
        parameters=[identified_parameter(parameter) for parameter in parameters],
        not_identifiable=[group] if unknown else [],
        effects=model_summary(robot).effects,
        expected="without a model, torque over angle is described, and no error of a fit is expected",
    )


def starting_values(data: MeasuredRuns, robot: CompliantRobot) -> dict[str, float]:
    """Return shapes of laws that have no value yet, from each joint's torque over angle.

    Only of laws that no other effect of the joint excludes: a curve that holds its linear term stands for it alone.

    Parameters
    ----------
    data : the campaign, with the table of readings. robot : the model.
    """
    wanted = [placed for placed in robot.placed if placed.place.kind == "joints" and not placed.values]
    readings = readings_of(data) if any(torque_curve(placed.effect) for placed in wanted) else None
    if readings is None:
        return {}
    result = clamped_result(data.campaign, readings)
    joints = {} if result is None else {joint.joint: joint for joint in result.joints}
    values: dict[str, float] = {}
    for placed in wanted:
        joint = joints.get(placed.place.joints[0])
        others = [other.effect.name for other in robot.placed if other is not placed and other.place == placed.place]
        form = torque_curve(placed.effect)
        if joint is None or form is None:
            continue
        if not {*form.includes, *form.excludes} & set(others):
            curve = zip(symbols_of(form), joint.coefficients.tolist(), strict=True)
            values |= {placed.parameter_name(symbol): value for symbol, value in curve}
    return values


def clamped_validation(data: MeasuredRuns) -> ExperimentValidation | None:
    """Return why nothing is judged where clamped runs make no load state; None where the states are, or there are none.

    States of clamped runs are judged like those of other runs.
    """
    if data.n_states or readings_of(data) is None:
        return None
    return ExperimentValidation(
        name=CLAMPED, scheme="none", section_scheme="none", rms={}, max={}, noise={}, relative={}, zero_model={},
        warnings=[WITHOUT_STATES],
    )  # fmt: skip


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
        elif chain.is_excited and quality.too_short:
            unusable.append(f"run {name}: {TOO_SHORT}")
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
