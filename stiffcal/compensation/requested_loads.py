"""The loads that a prediction is asked for: a table, one load in words, a path of loads at one pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.compensation.load_table import LoadTable, read_load_table
from stiffcal.compensation.option_words import OPTION_IN_N, numbers_of_words, pose_doubts, pose_of_words
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import is_given
from stiffcal.limits import BALANCES

if TYPE_CHECKING:
    from stiffcal.compensation.predict_result import LoadPath
    from stiffcal.compensation.prediction import Prediction


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


def requested_loads(
    campaign: Campaign, poses: Path | LoadTable | OneLoad | None, request: LoadPathRequest | None
) -> tuple[LoadTable, tuple[int, ...]]:
    """Return the states asked for, and where on a path its corners are.

    Raises
    ------
    InputError : the request is wrong.
    """
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


def described_path(
    campaign: Campaign, request: LoadPathRequest, loads: LoadTable, prediction: Prediction, corners: tuple[int, ...]
) -> LoadPath:
    """Return a path of loads with its deflection, named for the report."""
    from stiffcal.compensation.predict_result import LoadPath

    angles = campaign.chain.position_words(loads.joints[0])
    names = campaign.chain.joint_names
    pose = f"{names[0]} … {names[-1]} = {angles}" + (f"; {request.note}" if request.note else "")
    return LoadPath(campaign.name, pose, loads.wrench[:, :3], prediction.deflection[:, :3], corners)
