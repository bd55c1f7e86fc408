"""Corrected joint targets for a path with known or logged forces."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.loaded_columns import loaded_columns
from stiffcal.compensation.option_words import numbers_of_words
from stiffcal.compensation.path import CompensationPath
from stiffcal.compensation.path_forces import Forces
from stiffcal.compensation.table_doubts import deflection_doubts
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.quantity import LENGTH
from stiffcal.wording import angle, length, lines_in_words, significant

if TYPE_CHECKING:
    from stiffcal.compensation.compensate_result import (
        CompensateResult,
        CorrectedPose,
        PathError,
        PathJudgement,
        Wanted,
    )
    from stiffcal.compensation.targets import Corrected, PoseGoal
    from stiffcal.measurements.columns import Values
    from stiffcal.measurements.rms import Rms
    from stiffcal.mechanics.chain import Chain


@dataclass(frozen=True)
class CompensateRequest:
    """What is to be corrected, and how."""

    path: Path
    """CSV of the path (`read_path`)."""
    forces: Forces = field(default_factory=Forces)
    """Where the forces come from."""
    target: str | None = None
    """The frame that is to follow the path; None: the first measured one."""
    start: str | None = None
    """Joint angles near the first pose of a path in space, "A1,A2,…" in degrees."""
    orientation: bool = True
    """False where only the position counts."""
    sag: bool | None = None
    """True takes geometry errors and the sag under weight out too: the pose of robot.toml's rigid robot is meant; None:
    for paths in space, and for joint angles where the model holds the robot's geometry.
    """
    normal: str | None = None
    """"x,y,z" or "radial": the direction in which the picture shows the error; None: its length."""
    judge: Path | None = None
    """Another campaign, whose robot computes the error that the corrected targets leave."""


def corrected_path(
    fitted: FittedRobot, path: CompensationPath, target: str, options: CompensateRequest
) -> CompensateResult:
    """Correct the joint targets of a path so that the loaded robot goes where it is wanted.

    Parameters
    ----------
    fitted : the robot. path : with its loads. target : the frame that follows it. options : what is to be reached.

    Raises
    ------
    InputError : a load is more than the robot holds, or a pose cannot be had.
    """
    from stiffcal.compensation.compensate_result import CompensateResult
    from stiffcal.compensation.targets import CorrectionOptions, correct_joints
    from stiffcal.model.balance.equilibrium import NoBalanceError

    wanted = _wanted(fitted, path, options.sag)
    goal = _goal(fitted, path, wanted)
    # where the target is on the flange moves the rigid robot's pose as much as the real one's
    robot, covariance = fitted.with_target(target) if wanted == "path" else (fitted.robot, fitted.covariance)
    solve = CorrectionOptions(goal, options.orientation, fitted.robot.has_memory, path.time)
    try:
        corrected = correct_joints(robot, path.joints, path.wrench, path.setup, solve, covariance)
    except NoBalanceError as error:
        raise error.of_load(str(options.path), "", "give smaller loads") from error
    _check_reached(path, corrected)
    return CompensateResult(
        warnings=[
            *fitted.warnings,
            *(fitted.load_point_notes if path.wrench.any() and options.forces.frame is None else ()),
            *_warnings(path, corrected, options),
        ],
        values_from=fitted.source,
        target=target,
        wanted=wanted,
        rms_before=_rms(corrected.before),
        rms_after=_rms(corrected.after),
        residual_95=float(corrected.residual_95.max()) if fitted.covariance else None,
        largest_correction=np.abs(corrected.joints - path.joints).max(axis=0),
        rows=_corrected_poses(path, corrected),
        found=corrected,
        joint_names=fitted.campaign.chain.joint_names,
        joint_units=fitted.campaign.chain.position_units,
    )


def _wanted(fitted: FittedRobot, path: CompensationPath, sag: bool | None) -> Wanted:
    """Return which poses are wanted: the path's own, those of robot.toml's rigid robot, or those without the load.

    A model that holds the robot's geometry is there to correct it: joint angles then stand for where the rigid robot of
    robot.toml has them. Else they are taken as taught on the robot itself, weight and geometry errors included.
    """
    if sag is None:
        sag = path.goal is not None or any(placed.changes_geometry for placed in fitted.robot.placed)
    if not sag:
        return "unloaded robot"
    return "nominal robot" if path.goal is None else "path"


def _goal(fitted: FittedRobot, path: CompensationPath, wanted: Wanted) -> PoseGoal | None:
    """Return the wanted poses in base axes; None: those without the load."""
    from stiffcal.compensation.targets import PoseGoal
    from stiffcal.mechanics.kinematics import attached_poses

    if wanted == "unloaded robot":
        return None
    if wanted == "path":
        return path.goal
    chain = fitted.campaign.chain
    return PoseGoal(*attached_poses(chain, chain.model_angles(path.joints), path.setup.targets[0]))


def _check_reached(path: CompensationPath, corrected: Corrected) -> None:
    """Raise where not even the position can be reached: one fault for the lines that share a reason."""
    missed = ~corrected.position_reached
    if not missed.any():
        return
    held = np.array([bool(names) for names in corrected.held])
    stopped = sorted({name for row in np.flatnonzero(missed & held) for name in corrected.held[row]})
    singular = np.asarray(corrected.singular)
    kinds = (
        (held, f"{', '.join(stopped)} would have to exceed the limit", "keep the path farther from the limits"),
        (
            ~held & singular,
            "the robot is next to a singular pose, where a direction cannot be corrected",
            "move these rows some degrees away from it, or leave them out of the path",
        ),
        (~held & ~singular, "the corrected pose is out of reach", "move these rows, or leave them out of the path"),
    )
    faults = []
    for of_kind, reason, mend in kinds:
        rows = np.flatnonzero(missed & of_kind)
        if rows.size:
            left = float(np.linalg.norm(corrected.after[rows, :3], axis=1).max())
            place = lines_in_words(path.table.lines[rows], path.table.line_word)
            reason = f"{reason}: {'up to ' if rows.size > 1 else ''}{length(left)} remain"
            faults.append(Fault(FaultCode.POSE_UNREACHABLE, path.table.file, place, reason, mend))
    raise_faults(faults)


def judgement(
    fitted: FittedRobot, judge: FittedRobot, options: CompensateRequest, path: CompensationPath, corrected: Corrected
) -> PathJudgement:
    """Return the pose errors without and with the correction, by another campaign's robot.

    Parameters
    ----------
    fitted : whose targets are judged. judge : the other robot. options : with the other campaign's folder.
    path : the path. corrected : the targets.

    Raises
    ------
    InputError : it is no robot of the same joints.
    """
    from stiffcal.compensation.compensate_result import PathJudgement
    from stiffcal.compensation.targets import CorrectionOptions, errors_of

    if judge.campaign.chain.joint_names != fitted.campaign.chain.joint_names:
        raise InputError.at(
            FaultCode.ROBOT_MISMATCH, str(options.judge), "", "another robot", "choose a campaign of the same robot"
        )
    goal = _goal(judge, path, _wanted(fitted, path, options.sag))
    solve = CorrectionOptions(goal, options.orientation, judge.robot.has_memory, path.time)
    before, after = (
        errors_of(judge.robot, path.joints, commanded, path.wrench, path.setup, solve)
        for commanded in (path.joints, corrected.joints)
    )
    rms_after, rms_before = _rms(after).translation, _rms(before).translation
    return PathJudgement(
        by=str(options.judge),
        rms_before=_rms(before),
        rms_after=_rms(after),
        gone=1.0 - rms_after / rms_before if rms_after is not None and rms_before else None,
        campaign=judge.campaign.name,
        before=before,
        after=after,
    )


def _rms(errors: Floats) -> Rms:
    """Return the rms of pose errors (n, 6)."""
    from stiffcal.measurements.rms import Rms

    def rms(vectors: Floats) -> float:
        return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))

    return Rms(rms(errors[:, :3]), rms(errors[:, 3:]))


def _corrected_poses(path: CompensationPath, corrected: Corrected) -> list[CorrectedPose]:
    from stiffcal.compensation.compensate_result import CorrectedPose

    return [
        CorrectedPose(
            line=int(path.table.lines[k]),
            joints=path.joints[k],
            corrected=corrected.joints[k],
            wrench=path.wrench[k],
            deflection=corrected.deflection[k],
            error_before=corrected.before[k],
            error_after=corrected.after[k],
            residual_std=corrected.std[k],
            reached=bool(corrected.reached[k]),
            held=", ".join(corrected.held[k]),
        )
        for k in range(len(path.table))
    ]


def _warnings(path: CompensationPath, corrected: Corrected, options: CompensateRequest) -> list[str]:
    sentences = list(path.doubts)
    sentences += deflection_doubts(corrected.deflection, path.wrench, path.loads_from, path.unit_mend)
    only = corrected.position_reached & ~corrected.reached
    if options.orientation and only.any():
        worst = float(np.abs(corrected.after[only, 3:]).max())
        lines = lines_in_words(path.table.lines[only], path.table.line_word)
        limited = sorted({name for names in corrected.held for name in names})
        why = f"{', '.join(limited)} at its limit" if limited else "near a singular pose"
        sentences.append(
            f"{lines}: the position is reached, the orientation differs by up to {angle(worst, digits=2)} ({why})"
        )
    return sentences


_DECIMALS_OF_DEGREES = 9


def table_of_path(chain: Chain, result: CompensateResult, path: CompensationPath) -> dict[str, Values]:
    """Return the result as columns: degrees, N, N·m, mm, mrad, each with its unit."""
    corrected, judged = result.found, result.judged
    columns: dict[str, Values] = {}
    if path.time is not None:
        columns["t [s]"] = path.time
    if "segment" in path.table.words:
        columns["segment"] = list(path.table.words["segment"])
    # a billionth of a degree is no motion of a robot: below it stands the solver's rounding
    positions = np.round(chain.printed_positions(corrected.joints), _DECIMALS_OF_DEGREES) + 0.0
    columns |= loaded_columns(
        result.joint_names, chain.position_units, positions, path.wrench, corrected.deflection, corrected.std,
        "residual, standard uncertainty",
    )  # fmt: skip
    unit = LENGTH.usual
    columns[unit.in_brackets("residual, 95 %")] = unit.factor * corrected.residual_95
    columns["reached"] = corrected.reached.astype(np.int64)
    if judged is not None:
        columns[unit.in_brackets("judged before")] = unit.factor * np.linalg.norm(judged.before[:, :3], axis=1)
        columns[unit.in_brackets("judged after")] = unit.factor * np.linalg.norm(judged.after[:, :3], axis=1)
    return columns


def path_error(fitted: FittedRobot, path: CompensationPath, result: CompensateResult, normal: str | None) -> PathError:
    """Return the error along the path for its picture; ``normal`` as in `CompensateRequest`."""
    from stiffcal.compensation.compensate_result import PathError
    from stiffcal.mechanics.kinematics import attached_poses

    chain = fitted.campaign.chain
    if path.goal is not None:
        place = path.goal.position
    else:
        place, _ = attached_poses(chain, chain.model_angles(path.joints), path.setup.targets[0])
    source = result.judged or result.found
    direction, words = _direction(normal, place)
    return PathError(
        place=place,
        before=source.before[:, :3],
        after=source.after[:, :3],
        covariance=result.found.covariance[:, :3, :3],
        direction=direction,
        along=words,
        judge="the fitted model" if result.judged is None else result.judged.campaign,
        name=fitted.campaign.name,
    )


def _direction(normal: str | None, place: Floats) -> tuple[Floats | None, str]:
    """Return (n, 3) the unit direction in which the error is shown, and what to call it."""
    if normal is None:
        return None, "length of the error"
    if normal == "radial":
        outward = place - _centre_of_circle(place)
        return outward / np.linalg.norm(outward, axis=1, keepdims=True), "radial error, outward positive"
    numbers = np.array(numbers_of_words(normal, "--normal"))
    if numbers.shape != (3,) or not numbers.any():
        mend = 'write "x,y,z" in base axes, or "radial"'
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--normal", f"{normal!r} is not a direction", mend
        )
    unit = numbers / np.linalg.norm(numbers)
    return np.repeat(unit[None], len(place), axis=0), f"error along ({', '.join(significant(u) for u in unit)})"


def _centre_of_circle(place: Floats) -> Floats:
    """Return (3,) the centre of the circle that fits points (n, 3) best, by linear least squares in its plane."""
    middle = place.mean(axis=0)
    _, size, axes = np.linalg.svd(place - middle, full_matrices=False)
    if len(place) < 4 or size[1] < 1e-3 * size[0]:
        raise InputError.at(
            FaultCode.PATH_INVALID,
            "command line",
            "--normal",
            "the path is not a circle",
            'write "x,y,z" instead of radial',
        )
    flat = (place - middle) @ axes[:2].T
    design = np.concatenate([2.0 * flat, np.ones((len(flat), 1))], axis=1)
    solved = np.linalg.lstsq(design, np.sum(flat**2, axis=1), rcond=None)[0]
    return np.asarray(middle + solved[:2] @ axes[:2])
