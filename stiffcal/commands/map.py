"""Deflection or stiffness over the workspace."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.checks.prismatic_checks import refuse_prismatic
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.robot.sizes import HEAVIEST_KG
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.option_words import OPTION_IN_N, numbers_of_words, pose_of_words
from stiffcal.compensation.workspace_map import MapWish, map_of_robot, table_of_map
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from stiffcal.trust.output_kinds import MAP_PICTURE, MAP_TABLE
from stiffcal.trust.outputs import check_output, written

if TYPE_CHECKING:
    from stiffcal.compensation.map_result import MapResult


@dataclass(frozen=True)
class MapRequest:
    """What a person asks to see."""

    load: str | None = None
    """"Fx,Fy,Fz[,Tx,Ty,Tz]" in N and N·m, base axes, at the load point."""
    mass: float | None = None
    """kg hung on the load point: its weight is the load."""
    stiffness: str | None = None
    """"x", "y", "z" or "dx,dy,dz": stiffness along it is mapped too."""
    plane: str = "xz"
    """"xy", "xz" or "yz"."""
    at: float | None = None
    """m, where the plane cuts the third axis; None: through the middle of the reach."""
    slices: int = 1
    """More than one: so many parallel planes through the reach, a volume."""
    points: int = 41
    """Along the longer side of a plane."""
    pose: str | None = None
    """"A1,A2,…" in degrees, whose tool orientation is kept everywhere; None: the orientation is free."""
    target: str | None = None
    """The frame that is moved about; None: the first measured one."""


def map_campaign(
    folder: Path,
    request: MapRequest,
    context: RunContext | None = None,
    picture: Path | None = None,
    table: Path | None = None,
) -> MapResult:
    """Map deflection and stiffness over a plane or a volume of the workspace.

    Parameters
    ----------
    folder : a campaign folder with a fit, with logs to fit, or with a model file that values every parameter.
    request : load, plane and what is wanted.
    context : store, progress and so on.
    picture : SVG, PNG or PDF. table : CSV, workbook or Parquet with every point.

    Returns
    -------
    MapResult
        Every point, and the ranges of what was mapped.

    Raises
    ------
    InputError : the input is wrong, or the load is more than the robot holds.
    """
    context = context or RunContext()
    for file, kind in ((picture, MAP_PICTURE), (table, MAP_TABLE)):
        if file is not None:
            check_output(file, kind, context.overwrite)
    fitted = robot_to_map(Path(folder), context)
    result = replace(
        map_of_robot(fitted, _wish(fitted, request), context.progress),
        file=None if table is None else str(table),
        picture=None if picture is None else str(picture),
    )
    if table is not None:
        from stiffcal.store.table_files import write_table

        write_table(table_of_map(result), table, MAP_TABLE, overwrite=context.overwrite)
    if picture is not None:
        from stiffcal.report.figures.canvas import save_figure
        from stiffcal.report.figures.workspace import draw_workspace

        with written(picture, MAP_PICTURE, context.overwrite) as temporary:
            save_figure(draw_workspace(result), temporary)
    return result


def robot_to_map(folder: Path, context: RunContext) -> FittedRobot:
    """Return the fitted robot of a campaign, whose joints have to be revolute.

    Raises
    ------
    InputError : they are not, or the robot has no values.
    """
    campaign = load_campaign(folder, check_files=False)
    refuse_prismatic(
        campaign.chain.prismatic_names,
        "map reaches its points by revolute joints alone",
        "use stiffcal predict --poses with the poses of your choice",
    )
    return fitted_robot(campaign, context)


def _wish(fitted: FittedRobot, request: MapRequest) -> MapWish:
    """Return what the words of a request stand for."""
    return MapWish(
        wrench=_wrench(fitted, request),
        direction=_direction(request.stiffness),
        plane=request.plane,
        at=request.at,
        slices=request.slices,
        points=request.points,
        pose=None if request.pose is None else pose_of_words(request.pose, fitted.campaign.chain, "--pose"),
        target=request.target,
        load_from="--mass" if request.load is None else "--load",
        unit_mend=OPTION_IN_N if request.load else "",
    )


def _wrench(fitted: FittedRobot, request: MapRequest) -> Floats:
    if request.load is not None and request.mass is not None:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT, "command line", "--mass", "--load is already given", "give one of the two"
        )
    wrench = np.zeros(6)
    if request.mass is not None:
        if not 0.0 < request.mass < np.inf:
            raise InputError.at(
                FaultCode.OPTION_INVALID,
                "command line",
                "--mass",
                f"{request.mass:g} kg is no mass",
                "give a mass in kg",
            )
        if request.mass > HEAVIEST_KG:
            raise InputError.at(
                FaultCode.OPTION_INVALID,
                "command line",
                "--mass",
                f"{request.mass:g} kg is more than any robot carries",
                "give the mass in kg",
            )
        wrench[:3] = request.mass * fitted.robot.adjusted_chain.gravity
    elif request.load is not None:
        given = numbers_of_words(request.load, "--load")
        if len(given) not in (3, 6):
            mend = "write Fx,Fy,Fz or Fx,Fy,Fz,Tx,Ty,Tz"
            raise InputError.at(
                FaultCode.OPTION_INVALID, "command line", "--load", f"{request.load!r} is not a wrench", mend
            )
        wrench[: len(given)] = given
    return wrench


def _direction(words: str | None) -> Floats | None:
    if words is None:
        return None
    if words in ("x", "y", "z"):
        return np.asarray(np.eye(3)["xyz".index(words)])
    vector = np.array(numbers_of_words(words, "--stiffness"))
    if vector.shape != (3,) or not vector.any():
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--stiffness",
            f"{words!r} is not a direction",
            "write x, y, z or dx,dy,dz",
        )
    return np.asarray(vector / np.linalg.norm(vector))
