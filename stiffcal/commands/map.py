"""Deflection or stiffness over the workspace."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.prismatic_checks import refuse_prismatic
from stiffcal.campaign.sizes import HEAVIEST_KG, LONGEST_M
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.path import OPTION_IN_N, numbers_of_words, pose_doubts, pose_of_words
from stiffcal.compensation.table_doubts import deflection_doubts
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.quantity import ANGLE, LENGTH, ShownUnit, of_component
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from stiffcal.trust.output_kinds import MAP_PICTURE, MAP_TABLE
from stiffcal.trust.outputs import check_output, written

if TYPE_CHECKING:
    from stiffcal.compensation.map_result import MapGrid, MapResult, Plane
    from stiffcal.compensation.workspace import MapTask
    from stiffcal.measurements.columns import Values
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.mechanics.chain import Chain


PLANES: dict[Plane, tuple[int, int, int]] = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0)}
# A target that the joints move by less is on their axes: rounding, no place of work.
SMALLEST_REACH_M = 1e-6


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
    from stiffcal.compensation.map_result import MapResult, map_points
    from stiffcal.compensation.workspace import BEYOND_LIMITS, REACHED, map_workspace
    from stiffcal.model.equilibrium import NoBalanceError

    context = context or RunContext()
    for file, kind in ((picture, MAP_PICTURE), (table, MAP_TABLE)):
        if file is not None:
            check_output(file, kind, context.overwrite)
    campaign = load_campaign(Path(folder), check_files=False)
    refuse_prismatic(
        campaign.chain.prismatic_names,
        "map reaches its points by revolute joints alone",
        "use stiffcal predict --poses with the poses of your choice",
    )
    fitted = fitted_robot(campaign, context)
    setup, target = fitted.aimed_at(request.target)
    wrench = _wrench(fitted, request)
    direction = _direction(request.stiffness)
    if direction is None and not wrench.any():
        raise InputError.at(
            FaultCode.OPTION_MISSING, "command line", "--load", "nothing to map", "give --load, --mass or --stiffness"
        )
    task, grid = _grid(fitted, setup, request, wrench, direction)
    context.progress(f"computing {len(task.points)} poses", None)
    try:
        workspace = map_workspace(fitted.robot, setup, task, fitted.covariance)
    except NoBalanceError as error:
        raise error.of_load("command line", "--load", "give a smaller load") from error
    reached = workspace.status == REACHED
    result = MapResult(
        warnings=[
            *_doubts(campaign.chain, request, task, workspace.deflection[reached]),
            *fitted.warnings,
            *fitted.load_point_notes,
            *_nothing_reached(reached),
        ],
        values_from=fitted.source,
        target=target,
        wrench=task.wrench,
        plane=_plane(request.plane),
        levels=grid.levels,
        shape=grid.shape,
        reached=int(reached.sum()),
        beyond_limits=int((workspace.status == BEYOND_LIMITS).sum()),
        position_error=_ends(workspace.position_error),
        orientation_error=_ends(workspace.orientation_error),
        stiffness=_ends(workspace.stiffness),
        points=map_points(workspace),
        file=None if table is None else str(table),
        picture=None if picture is None else str(picture),
        task=task,
        grid=grid,
        found=workspace,
    )
    if table is not None:
        from stiffcal.store.table_files import write_table

        write_table(_table(result), table, MAP_TABLE, overwrite=context.overwrite)
    if picture is not None:
        from stiffcal.report.figures.canvas import save_figure
        from stiffcal.report.figures.workspace import draw_workspace

        with written(picture, MAP_PICTURE, context.overwrite) as temporary:
            save_figure(draw_workspace(result), temporary)
    return result


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


def _plane(words: str) -> Plane:
    for plane in PLANES:
        if plane == words:
            return plane
    raise InputError.at(
        FaultCode.OPTION_INVALID, "command line", "--plane", f"no plane {words}", f"one of {', '.join(PLANES)}"
    )


def _grid(
    fitted: FittedRobot, setup: MeasurementSetup, request: MapRequest, wrench: Floats, direction: Floats | None
) -> tuple[MapTask, MapGrid]:
    """Return the task of the map, and how its points lie."""
    from stiffcal.compensation.inverse import middle_of_ranges
    from stiffcal.compensation.map_result import MapGrid
    from stiffcal.compensation.workspace import MapTask, reached_box
    from stiffcal.mechanics.kinematics import attached_poses, body_poses

    plane = _plane(request.plane)
    if not (2 <= request.points <= 400 and 1 <= request.slices <= 30):
        mend = "2 to 400 points along a side, 1 to 30 slices"
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--points",
            f"{request.points} points, {request.slices} slices",
            mend,
        )
    if request.at is not None and not abs(request.at) <= LONGEST_M:
        reason = f"{request.at:g} m is beyond the reach of any robot"
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--at", reason, "give the height of the plane in m"
        )
    if request.mass is not None and request.mass > HEAVIEST_KG:
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--mass",
            f"{request.mass:g} kg is more than any robot carries",
            "give the mass in kg",
        )
    chain = fitted.campaign.chain
    across, up, third = PLANES[plane]
    box = reached_box(chain, setup.targets[0])
    middle = float(box[third].mean()) if request.at is None else request.at
    levels = np.array([middle])
    if request.slices > 1:
        # the outermost slices would only touch the reach
        edge = 0.5 / request.slices
        levels = box[third, 0] + np.ptp(box[third]) * np.linspace(edge, 1.0 - edge, request.slices)
    sides = np.ptp(box, axis=1)[[across, up]]
    if not sides.max() > SMALLEST_REACH_M:
        raise InputError.at(
            FaultCode.POSE_UNREACHABLE,
            "command line",
            "--plane",
            f"the joints do not move the target in the plane {plane}: nothing to map",
            "choose a plane in which it moves, or place the target off the joint axes",
        )
    counts = np.maximum(2, np.round(request.points * sides / sides.max())).astype(int)
    ends = box[[across, up]]
    columns, rows = (np.linspace(low, high, int(count)) for (low, high), count in zip(ends, counts, strict=True))
    home, rotation = middle_of_ranges(chain), None
    if request.pose is not None:
        home = pose_of_words(request.pose, chain, "--pose")
        _, turned = attached_poses(chain, chain.model_angles(home[None]), setup.targets[0])
        rotation = turned[0]
    arm, _ = body_poses(chain, chain.model_angles(home[None]))
    grid = MapGrid(
        across=columns,
        up=rows,
        levels=levels,
        axes=(across, up, third),
        campaign=fitted.campaign.name,
        joint_names=chain.joint_names,
        arm=arm[0][:, [across, up]],
    )
    return MapTask(grid.points, home, rotation, wrench, direction), grid


def _ends(values: Floats) -> Floats | None:
    """Return (2,) the smallest and the largest known value, None where none is known."""
    finite = values[np.isfinite(values)]
    return np.array([finite.min(), finite.max()]) if finite.size else None


def _doubts(chain: Chain, request: MapRequest, task: MapTask, deflection: Floats) -> Iterator[str]:
    """Yield warnings where the pose or the load, with the deflections (n, 6) that it makes, look like other units."""
    if request.pose is not None:
        yield from pose_doubts(task.home, chain, "--pose")
    if len(deflection):
        where = "--mass" if request.load is None else "--load"
        yield from deflection_doubts(deflection, task.wrench[None], where, OPTION_IN_N if request.load else "")


def _nothing_reached(reached: NDArray[np.bool_]) -> Iterator[str]:
    if not reached.any():
        yield "the robot reaches none of the points: choose another plane or another --pose"


def _table(result: MapResult) -> dict[str, Values]:
    """Return every point as columns, each with its unit."""
    workspace = result.found
    length, angle, stiffness = LENGTH.usual, ANGLE.usual, ShownUnit("N/mm", 1e-3)
    columns: dict[str, Values] = {
        length.in_brackets(axis): length.factor * workspace.points[:, k] for k, axis in enumerate("XYZ")
    }
    columns["status"] = [point.status for point in result.points]
    columns |= {f"{name} [deg]": np.degrees(workspace.joints[:, k]) for k, name in enumerate(result.grid.joint_names)}
    for k, name in enumerate(("dx", "dy", "dz", "rx", "ry", "rz")):
        unit = of_component(k).usual
        columns[unit.in_brackets(name)] = unit.factor * workspace.deflection[:, k]
    columns[length.in_brackets("position error")] = length.factor * workspace.position_error
    columns[angle.in_brackets("orientation error")] = angle.factor * workspace.orientation_error
    columns[length.in_brackets("position error, standard uncertainty")] = length.factor * workspace.std[:, 0]
    columns[angle.in_brackets("orientation error, standard uncertainty")] = angle.factor * workspace.std[:, 1]
    columns[stiffness.in_brackets("stiffness")] = stiffness.factor * workspace.stiffness
    columns["limit margin [deg]"] = np.degrees(workspace.margin)
    columns["smallest singular value"] = workspace.smallest_singular
    return columns
