"""Predict deflection and stiffness of a fitted robot under given loads."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.compensation.load_table import LoadTable, read_load_table
from stiffcal.compensation.option_words import OPTION_IN_N, numbers_of_words, pose_doubts, pose_of_words
from stiffcal.compensation.predicted_states import predicted_states, table_of_states, unknown_twists
from stiffcal.compensation.table_doubts import deflection_doubts
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import is_given
from stiffcal.limits import BALANCES
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import LOAD_PATHS, RunContext, open_store
from stiffcal.trust.output_kinds import PREDICTION
from stiffcal.trust.outputs import check_output

if TYPE_CHECKING:
    from stiffcal.compensation.predict_result import LoadPath, PredictResult
    from stiffcal.compensation.prediction import Prediction
    from stiffcal.store.store_place import Documents, Stored


@dataclass(frozen=True)
class LoadPathRequest:
    """A path of loads at one pose."""

    corners: str
    """"Fx,Fy,Fz;Fx,Fy,Fz;…" in N, base axes, or the name of a CSV file with columns Fx … Tz."""
    pose: str | None = None
    """Joint angles in degrees, "A1,A2,…", in the order of the robot file; None: the file's joint columns."""
    points: int = 20
    """Steps on each leg."""
    note: str = ""
    """Words for the report: what is shown, and how the pose was found."""


@dataclass(frozen=True)
class OneLoad:
    """One load at one pose."""

    pose: str
    """Joint angles in degrees (prismatic joints: mm), "A1,A2,…", in the order of the robot file."""
    force: str = "0,0,0"
    """"Fx,Fy,Fz" in N or "Fx,Fy,Fz,Tx,Ty,Tz" in N and N·m, base axes."""


def predict_campaign(
    folder: Path,
    context: RunContext | None = None,
    poses: Path | LoadTable | OneLoad | None = None,
    load_path: LoadPathRequest | None = None,
    output: Path | None = None,
) -> PredictResult:
    """Predict deflection and Cartesian stiffness at the first measured frame.

    Parameters
    ----------
    folder : a campaign folder: one with a fit, or with logs to fit, or with a model file that values every parameter.
    context : store, progress and so on.
    poses : CSV with a column per joint (degrees) and Fx … Tz (N, N·m): base axes, on the robot, at the manifest's load
        point; one state a row. Or the same as arrays, or one load in words.
    load_path : instead of ``poses``.
    output : CSV, workbook or Parquet to write the result to.

    Returns
    -------
    PredictResult
        Every state, and the path of loads where one was asked for.

    Raises
    ------
    InputError : the input is wrong, or a load is more than the robot holds.
    """
    from stiffcal.compensation.link_parts import link_parts
    from stiffcal.compensation.predict_result import PredictResult
    from stiffcal.compensation.prediction import at_load_point, one_run, predict_states
    from stiffcal.model.balance.equilibrium import NoBalanceError

    context = context or RunContext()
    if (poses is None) == (load_path is None):
        code = FaultCode.OPTION_MISSING if poses is None else FaultCode.OPTION_CONFLICT
        reason = "nothing to predict is stated" if poses is None else "more than one thing to predict is given"
        mend = "give one of --pose A1,A2,… --force Fx,Fy,Fz, --poses FILE and --load-path F;F"
        place = "--pose" if isinstance(poses, OneLoad) else "--poses"
        raise InputError.at(code, "command line", place, reason, mend)
    if output is not None:
        check_output(output, PREDICTION, context.overwrite)
    campaign = load_campaign(Path(folder), check_files=False)
    loads, corners = _requested_loads(campaign, poses, load_path)
    fitted = fitted_robot(campaign, context)
    context.progress("predicting", None)
    try:
        prediction = predict_states(
            fitted.robot, loads.joints, loads.wrench, fitted.setup, fitted.covariance, in_order=load_path is not None
        )
    except NoBalanceError as error:
        if isinstance(poses, OneLoad):
            raise error.of_load("command line", f"--force {poses.force}", "give a smaller force") from error
        if load_path is None:
            raise error.of_load(str(poses) if isinstance(poses, Path) else "poses", "", "give smaller loads") from error
        raise error.of_load("command line", f"--load-path {load_path.corners}", "give smaller loads") from error
    order = one_run(fitted.robot, len(loads.joints)) if load_path is not None else None
    angles, setup = fitted.robot.chain.model_angles(loads.joints), at_load_point(fitted.setup)
    parts = link_parts(fitted.robot, angles, loads.wrench, setup, order, fitted.link_compliances)
    path = None if load_path is None else _load_path(campaign, load_path, loads, prediction, corners)
    result = PredictResult(
        warnings=[
            *loads.doubts,
            *deflection_doubts(prediction.deflection, loads.wrench, loads.where, loads.unit_mend),
            *fitted.warnings,
            *fitted.load_point_notes,
            *unknown_twists(fitted, parts),
        ],
        values_from=fitted.source,
        target=fitted.setup.target_names[0],
        states=predicted_states(loads, prediction, parts),
        load_path=path,
        file=None if output is None else str(output),
        joint_names=campaign.chain.joint_names,
        joint_units=campaign.chain.position_units,
    )
    if path is not None and context.trial is None:
        _keep(campaign, context, path)
    if output is not None:
        from stiffcal.store.table_files import write_table

        write_table(table_of_states(result), output, PREDICTION, overwrite=context.overwrite)
    return result


def _requested_loads(
    campaign: Campaign, poses: Path | LoadTable | OneLoad | None, request: LoadPathRequest | None
) -> tuple[LoadTable, tuple[int, ...]]:
    """Return the states asked for, and where on a path its corners are."""
    from stiffcal.compensation.prediction import load_path

    names, prismatic = campaign.chain.joint_names, campaign.chain.prismatic_names
    if isinstance(poses, LoadTable):
        return poses, ()
    if isinstance(poses, OneLoad):
        return _one_load(campaign, poses), ()
    if poses is not None:
        return read_load_table(Path(poses), names, joints_needed=True, prismatic=prismatic), ()
    assert request is not None
    doubts, where, mend = [], "--load-path", OPTION_IN_N
    if is_given(Path(request.corners)):
        table = read_load_table(Path(request.corners), names, request.pose is None, prismatic)
        corner_loads, pose = table.wrench, table.joints[0]
        doubts, where, mend = list(table.doubts), table.where, table.unit_mend
        if request.pose is None and np.ptp(table.joints, axis=0).max() > 0.0:
            raise InputError.at(
                FaultCode.PATH_INVALID,
                request.corners,
                "",
                "the joints move along the load path",
                "a load path has one pose; use --poses",
            )
    else:
        corner_loads, pose = _corners(request.corners), np.zeros(len(names))
    if request.pose is not None:
        pose = pose_of_words(request.pose, campaign.chain, "--at")
        doubts += pose_doubts(pose, campaign.chain, "--at")
    elif not is_given(Path(request.corners)):
        raise InputError.at(
            FaultCode.OPTION_MISSING,
            "command line",
            "--at",
            "no pose given",
            f"give {len(names)} joint angles in degrees",
        )
    if request.points < 1 or len(corner_loads) < 2:
        mend = "give two loads or more, and at least one point on each leg"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--load-path", "not a load path", mend)
    BALANCES.check(request.points * (len(corner_loads) - 1), "--points")
    wrench, corners = load_path(corner_loads, request.points)
    return LoadTable(np.repeat(pose[None], len(wrench), axis=0), wrench, tuple(doubts), where, mend), corners


def _one_load(campaign: Campaign, one: OneLoad) -> LoadTable:
    """Return one state."""
    pose, load = pose_of_words(one.pose, campaign.chain, "--pose"), numbers_of_words(one.force, "--force")
    if len(load) not in (3, 6):
        reason, mend = f"{one.force!r} is no force", "write it like 0,0,-500: Fx,Fy,Fz in N, base axes"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--force", reason, mend)
    wrench = np.zeros((1, 6))
    wrench[0, : len(load)] = load
    return LoadTable(pose[None], wrench, tuple(pose_doubts(pose, campaign.chain, "--pose")), "--force", OPTION_IN_N)


def _corners(text: str) -> Floats:
    rows = [numbers_of_words(corner, "--load-path") for corner in text.split(";") if corner.strip()]
    if not rows or any(len(row) != len(rows[0]) for row in rows) or len(rows[0]) not in (3, 6):
        mend = 'write forces like "-100,200,-300;0,0,0;100,-200,100", or name a CSV file'
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--load-path", f"{text!r} is not a list of loads", mend
        )
    return np.array(rows)


def _load_path(
    campaign: Campaign, request: LoadPathRequest, loads: LoadTable, prediction: Prediction, corners: tuple[int, ...]
) -> LoadPath:
    from stiffcal.compensation.predict_result import LoadPath

    angles = campaign.chain.position_words(loads.joints[0])
    names = campaign.chain.joint_names
    pose = f"{names[0]} … {names[-1]} = {angles}" + (f"; {request.note}" if request.note else "")
    return LoadPath(campaign.name, pose, loads.wrench[:, :3], prediction.deflection[:, :3], corners)


def _keep(campaign: Campaign, context: RunContext, path: LoadPath) -> None:
    """Keep the path in the store, where the report finds it; one of each name and pose."""

    def with_path(stored: Stored) -> Documents:
        kept = stored(LOAD_PATHS) or {"schema": "stiffcal/load-paths/1", "paths": []}
        kept_paths = [
            entry for entry in kept["paths"] if (entry.get("name"), entry.get("pose")) != (path.name, path.pose)
        ]
        return {LOAD_PATHS: kept | {"paths": [*kept_paths, document_of(path)]}}

    open_store(campaign.folder, context).commit(documents=with_path, command="predict")
