"""What `map` answers: the points of a plane or a volume with what was found there, for JSON, tables and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.workspace import MapTask, WorkspaceMap
from stiffcal.document_arrays import Vector
from stiffcal.documents import NOT_IN_DOCUMENT, CommandResult, Number, OrAbsent

Plane: TypeAlias = Literal["xy", "xz", "yz"]
Status: TypeAlias = Literal["out of reach", "only beyond joint limits", "reached"]
STATUS: tuple[Status, ...] = ("out of reach", "only beyond joint limits", "reached")


@dataclass(frozen=True, slots=True, kw_only=True)
class MapGrid:
    """Parallel planes of points, (S, R, C) of them."""

    across: Floats
    """(C,) m, the points' coordinates along a row."""
    up: Floats
    """(R,) m, the points' coordinates along a column."""
    levels: Floats
    """(S,) m, where the planes lie along the third axis."""
    axes: tuple[int, int, int]
    """Which base axes run across, up and through the planes."""
    campaign: str
    """The campaign's name."""
    joint_names: tuple[str, ...]
    """Of the logged joints, L of them."""
    arm: Floats
    """(K, 2) m, base axes across and up: the arm in the pose that solutions are near to."""

    @property
    def shape(self) -> tuple[int, int, int]:
        """Planes, rows, points of a row."""
        return len(self.levels), len(self.up), len(self.across)

    @property
    def points(self) -> Floats:
        """(S·R·C, 3) m, base axes: plane after plane, row after row."""
        across, up, through = self.axes
        points = np.zeros((*self.shape, 3))
        points[..., through] = self.levels[:, None, None]
        points[..., across], points[..., up] = self.across, self.up[:, None]
        return points.reshape(-1, 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class MapPoint:
    """A point of a map: None, and NaN (null in the document), where the robot does not reach it."""

    position: Vector
    """(3,) m, base axes."""
    status: Status
    """Whether the robot reaches it."""
    joints: Vector | None
    """(L,) rad, logged angles."""
    deflection: Vector | None
    """(6,) m, rad, base axes."""
    std: Vector | None
    """(2,) standard uncertainty of the deflection's position and rotation, m, rad."""
    stiffness: Number
    """N/m, along the direction that was asked for."""
    limit_margin: Number
    """rad, to the nearest joint limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapResult(CommandResult):
    """Answer of ``map``: points plane after plane, row after row; smallest and largest of what is mapped."""

    schema: Literal["stiffcal/map/1"] = "stiffcal/map/1"
    values_from: str
    """Where the model's values are from, in words."""
    target: str
    """The frame that is moved about."""
    wrench: Vector
    """(6,) N, N·m, base axes, at the load point."""
    plane: Plane
    """The base axes of the planes."""
    levels: Vector
    """(S,) m, where the planes cut the third axis."""
    shape: tuple[int, ...]
    """Planes, rows, points of a row: (S, R, C)."""
    reached: int
    """How many points are reached."""
    beyond_limits: int
    """How many are reached beyond joint limits alone."""
    position_error: Vector | None
    """(2,) m, smallest and largest length of the deflection."""
    orientation_error: Vector | None
    """(2,) rad, smallest and largest angle of the deflection."""
    stiffness: Vector | None
    """(2,) N/m, smallest and largest."""
    points: list[MapPoint]
    """Every point, S·R·C of them."""
    file: OrAbsent[str] = None
    """The table that was written."""
    picture: OrAbsent[str] = None
    """The picture that was written."""
    task: Annotated[MapTask, NOT_IN_DOCUMENT]
    """What was asked for."""
    grid: Annotated[MapGrid, NOT_IN_DOCUMENT]
    """How the points lie."""
    found: Annotated[WorkspaceMap, NOT_IN_DOCUMENT]
    """The points as arrays."""

    @property
    def worst(self) -> MapPoint | None:
        """The reached point with the largest position error, without a load the softest; None where none is reached."""
        values = self.found.position_error if np.any(self.wrench) else -self.found.stiffness
        reached = np.array([point.status == "reached" for point in self.points]) & np.isfinite(values)
        return self.points[int(np.argmax(np.where(reached, values, -np.inf)))] if reached.any() else None


def map_points(workspace: WorkspaceMap) -> list[MapPoint]:
    """Return each point of a map by itself."""

    def known(values: Floats) -> Floats | None:
        return values if np.isfinite(values).all() else None

    return [
        MapPoint(
            position=workspace.points[k],
            status=STATUS[int(workspace.status[k])],
            joints=known(workspace.joints[k]),
            deflection=known(workspace.deflection[k]),
            std=known(workspace.std[k]),
            stiffness=float(workspace.stiffness[k]),
            limit_margin=float(workspace.margin[k]),
        )
        for k in range(len(workspace.points))
    ]
