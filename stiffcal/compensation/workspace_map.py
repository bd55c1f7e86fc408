"""Deflection or stiffness over the workspace."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.sizes import LONGEST_M
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.option_words import OPTION_IN_N, pose_doubts
from stiffcal.compensation.table_doubts import deflection_doubts
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.quantity import ANGLE, LENGTH, ShownUnit, of_component

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
class MapWish:
    """What is to be mapped."""

    wrench: Floats
    """(6,) N, N·m, base axes, on the robot at the load point."""
    direction: Floats | None = None
    """(3,) unit vector, base axes: the stiffness along it is mapped too."""
    plane: str = "xz"
    """"xy", "xz" or "yz"."""
    at: float | None = None
    """m, where the plane cuts the third axis; None: through the middle of the reach."""
    slices: int = 1
    """More than one: so many parallel planes through the reach, a volume."""
    points: int = 41
    """Along the longer side of a plane."""
    pose: Floats | None = None
    """(L,) rad, logged angles, whose tool orientation is kept everywhere; None: the orientation is free."""
    target: str | None = None
    """The frame that is moved about; None: the first measured one."""
    load_from: str = "--load"
    """Where the load is from, for doubts about its unit."""
    unit_mend: str = OPTION_IN_N
    """What to do where the load is in another unit; empty: its unit is stated."""


def map_of_robot(fitted: FittedRobot, wish: MapWish, progress: Progress = no_progress) -> MapResult:
    """Map deflection and stiffness over a plane or a volume of the workspace.

    Raises
    ------
    InputError : nothing is to be mapped, what is wished is impossible, or the load is more than the robot holds.
    """
    from stiffcal.compensation.map_result import MapResult, map_points
    from stiffcal.compensation.workspace import BEYOND_LIMITS, REACHED, map_workspace
    from stiffcal.model.balance.equilibrium import NoBalanceError

    setup, target = fitted.aimed_at(wish.target)
    if wish.direction is None and not wish.wrench.any():
        raise InputError.at(
            FaultCode.OPTION_MISSING, "command line", "--load", "nothing to map", "give --load, --mass or --stiffness"
        )
    task, grid = _grid(fitted, setup, wish)
    progress(f"computing {len(task.points)} poses", None)
    try:
        workspace = map_workspace(fitted.robot, setup, task, fitted.covariance)
    except NoBalanceError as error:
        raise error.of_load("command line", "--load", "give a smaller load") from error
    reached = workspace.status == REACHED
    return MapResult(
        warnings=[
            *_doubts(fitted.campaign.chain, wish, task, workspace.deflection[reached]),
            *fitted.warnings,
            *fitted.load_point_notes,
            *_nothing_reached(reached),
        ],
        values_from=fitted.source,
        target=target,
        wrench=task.wrench,
        plane=_plane(wish.plane),
        levels=grid.levels,
        shape=grid.shape,
        reached=int(reached.sum()),
        beyond_limits=int((workspace.status == BEYOND_LIMITS).sum()),
        position_error=_ends(workspace.position_error),
        orientation_error=_ends(workspace.orientation_error),
        stiffness=_ends(workspace.stiffness),
        points=map_points(workspace),
        task=task,
        grid=grid,
        found=workspace,
    )


def _plane(words: str) -> Plane:
    for plane in PLANES:
        if plane == words:
            return plane
    raise InputError.at(
        FaultCode.OPTION_INVALID, "command line", "--plane", f"no plane {words}", f"one of {', '.join(PLANES)}"
    )


def _grid(fitted: FittedRobot, setup: MeasurementSetup, wish: MapWish) -> tuple[MapTask, MapGrid]:
    """Return the task of the map, and how its points lie."""
    from stiffcal.compensation.inverse import middle_of_ranges
    from stiffcal.compensation.map_result import MapGrid
    from stiffcal.compensation.workspace import MapTask, reached_box
    from stiffcal.mechanics.kinematics import attached_poses, body_poses

    plane = _plane(wish.plane)
    if not (2 <= wish.points <= 400 and 1 <= wish.slices <= 30):
        mend = "2 to 400 points along a side, 1 to 30 slices"
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--points",
            f"{wish.points} points, {wish.slices} slices",
            mend,
        )
    if wish.at is not None and not abs(wish.at) <= LONGEST_M:
        reason = f"{wish.at:g} m is beyond the reach of any robot"
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--at", reason, "give the height of the plane in m"
        )
    chain = fitted.campaign.chain
    across, up, third = PLANES[plane]
    box = reached_box(chain, setup.targets[0])
    middle = float(box[third].mean()) if wish.at is None else wish.at
    levels = np.array([middle])
    if wish.slices > 1:
        # the outermost slices would only touch the reach
        edge = 0.5 / wish.slices
        levels = box[third, 0] + np.ptp(box[third]) * np.linspace(edge, 1.0 - edge, wish.slices)
    sides = np.ptp(box, axis=1)[[across, up]]
    if not sides.max() > SMALLEST_REACH_M:
        raise InputError.at(
            FaultCode.POSE_UNREACHABLE,
            "command line",
            "--plane",
            f"the joints do not move the target in the plane {plane}: nothing to map",
            "choose a plane in which it moves, or place the target off the joint axes",
        )
    counts = np.maximum(2, np.round(wish.points * sides / sides.max())).astype(int)
    ends = box[[across, up]]
    columns, rows = (np.linspace(low, high, int(count)) for (low, high), count in zip(ends, counts, strict=True))
    home, rotation = middle_of_ranges(chain), None
    if wish.pose is not None:
        home = wish.pose
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
    return MapTask(grid.points, home, rotation, wish.wrench, wish.direction), grid


def _ends(values: Floats) -> Floats | None:
    """Return (2,) the smallest and the largest known value, None where none is known."""
    finite = values[np.isfinite(values)]
    return np.array([finite.min(), finite.max()]) if finite.size else None


def _doubts(chain: Chain, wish: MapWish, task: MapTask, deflection: Floats) -> Iterator[str]:
    """Yield warnings where the pose or the load, with the deflections (n, 6) that it makes, look like other units."""
    if wish.pose is not None:
        yield from pose_doubts(task.home, chain, "--pose")
    if len(deflection):
        yield from deflection_doubts(deflection, task.wrench[None], wish.load_from, wish.unit_mend)


def _nothing_reached(reached: NDArray[np.bool_]) -> Iterator[str]:
    if not reached.any():
        yield "the robot reaches none of the points: choose another plane or another --pose"


def table_of_map(result: MapResult) -> dict[str, Values]:
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
