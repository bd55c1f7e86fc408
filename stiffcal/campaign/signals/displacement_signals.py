"""Signals of what moved: poses, displacements, gauges and the rods of integral deformation sensors."""

from __future__ import annotations

from typing import Annotated, ClassVar, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from stiffcal.campaign.signals.signal import Signal
from stiffcal.campaign.toml.typed import (
    AngleUnit,
    Columns,
    Columns3,
    Columns4,
    Columns9,
    LengthUnit,
    Name,
    Positive,
    RodUnit,
    TomlTable,
    Vector3,
    WrongValueError,
    columns_of_count,
    expand_columns,
)
from stiffcal.quantities import Unit, unit, unit_names


def _sigma(value: object) -> float | tuple[str, ...]:
    if isinstance(value, int | float) and not isinstance(value, bool):
        if not value > 0.0:
            raise WrongValueError(f"found {value:g}", "write a positive number, or the columns that hold it")
        return float(value)
    return columns_of_count(1, 3)(expand_columns(value))


StatedSigma: TypeAlias = Annotated[
    float | tuple[str, ...],
    BeforeValidator(_sigma),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "exclusiveMinimum": 0},
                {"type": "string"},
                {"type": "array", "items": {"type": "string"}, "minItems": 1},
            ]
        }
    ),
]
"""A number for all readings, or the column (for all axes) or three columns that hold it, row by row."""


class PoseUnits(TomlTable):
    """Units of a pose; `rotation` is for rotvec and rpy."""

    position: LengthUnit = "m"
    rotation: AngleUnit = "rad"


class PoseSigma(TomlTable):
    """Standard uncertainty of one reading: position in its unit, rotation in its unit (rad for a quaternion).

    Attributes
    ----------
    position : of absolute places that come from points and state no rotation, of each point: the pose's follows.
    per_metre : added to that of the position for each metre between instrument and target, in the position's unit.
    coverage : how many standard uncertainties the columns hold: 2 of an expanded uncertainty, U(95).
    """

    position: StatedSigma | None = None
    rotation: StatedSigma | None = None
    per_metre: Positive | None = None
    coverage: Positive = 1.0


class Marker(TomlTable):
    """One of several points on a body.

    Attributes
    ----------
    columns : its three coordinates; empty or NaN while it is hidden.
    at_m : its place on the body, m; left out where a frame of the same name gives it.
    """

    columns: Columns3
    at_m: Vector3 | None = None


def _marker(value: object) -> object:
    return {"columns": value} if isinstance(value, list | tuple | str) else value


MarkerEntry: TypeAlias = Annotated[Marker, BeforeValidator(_marker)]


ORIENTATIONS = ("quaternion_wxyz", "rotvec", "rpy", "matrix")
"""The ways to write an orientation."""
WITHOUT_UNIT = ("quaternion_wxyz", "matrix")
"""Those of them whose columns have no unit."""


class Pose(Signal):
    """Position and, where measured, orientation of one body.

    Attributes
    ----------
    frame : the instrument's frame. body : the frame or link that is measured.
    position : three columns. quaternion_wxyz, rotvec, rpy (fixed x, y, z) or matrix (nine, row by row): the columns of
        the orientation.
    markers : instead of `position`: name to three columns, or to { columns, at_m }.
    """

    frame: Name = "base"
    body: Name | None = None
    position: Columns3 | None = None
    quaternion_wxyz: Columns4 | None = None
    rotvec: Columns3 | None = None
    rpy: Columns3 | None = None
    matrix: Columns9 | None = None
    markers: dict[str, MarkerEntry] = Field(default_factory=dict)
    units: PoseUnits = PoseUnits()
    sigma: PoseSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"position": "length", "rotation": "rotation"}
    look_alikes: ClassVar[dict[str, str]] = {
        "columns": "position", "quaternion": "quaternion_wxyz", "axes": "frame", "rotation": "rotvec",
    }  # fmt: skip

    @property
    def orientation(self) -> tuple[str, tuple[str, ...]] | None:
        """Return how the orientation is written and its columns, None where it is not measured."""
        for key in ORIENTATIONS:
            columns = getattr(self, key)
            if columns is not None:
                return key, columns
        return None

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        marked = tuple(name for marker in self.markers.values() for name in marker.columns)
        return (self.position or marked) + (self.orientation[1] if self.orientation else ())

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit; a quaternion's have none."""
        length, rotation = self.unit_of("position"), self.unit_of("rotation")
        marked = tuple(name for marker in self.markers.values() for name in marker.columns)
        unit_of_column = dict.fromkeys(self.position or marked, length)
        if self.orientation is not None and self.orientation[0] not in WITHOUT_UNIT:
            unit_of_column.update(dict.fromkeys(self.orientation[1], rotation))
        return unit_of_column

    @model_validator(mode="after")
    def _one_way(self) -> Pose:
        written = [key for key in ORIENTATIONS if getattr(self, key) is not None]
        if len(written) > 1:
            raise WrongValueError(f"the orientation is given twice, as {' and '.join(written)}", "keep one of them")
        if (self.position is None) == (not self.markers):
            raise WrongValueError("a pose needs either position or markers", 'write position = ["X", "Y", "Z"]')
        if self.markers and self.sigma is not None and self.sigma.per_metre is not None:
            raise WrongValueError("sigma.per_metre belongs to a position, and markers are read", "remove per_metre")
        if self.markers and len(self.markers) < 3:
            raise WrongValueError(f"{len(self.markers)} markers do not give a pose", "give three or more")
        if self.markers and written:
            raise WrongValueError(f"markers give the orientation, and {written[0]} too", "keep one of them")
        return self


class LengthUnits(TomlTable):
    """Unit of lengths."""

    length: LengthUnit = "m"


class LengthSigma(TomlTable):
    """Standard uncertainty of one reading, in the signal's unit."""

    length: Positive | None = None


class RodUnits(TomlTable):
    """Unit of rods' length changes; a strain counts in the length of each rod."""

    length: RodUnit = "m"


class Lengths(Signal):
    """Length changes of integral deformation sensors; each column is a rod under `[ids]`."""

    columns: Columns
    units: RodUnits = RodUnits()
    sigma: LengthSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"length": "length"}

    def unit_of(self, key: str) -> Unit:
        """Return the unit of the columns: of a length, m, or of a strain, which each rod's length makes one."""
        written = self.units.length
        return unit(written, "strain" if written in unit_names("strain") else self.quantity_of[key])

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return self.columns

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        return dict.fromkeys(self.columns, self.unit_of("length"))


class DeflectionUnits(TomlTable):
    """Units of a displacement already taken."""

    translation: LengthUnit = "m"
    rotation: AngleUnit = "rad"


class DeflectionSigma(TomlTable):
    """Standard uncertainty of one reading, in the signal's units.

    Attributes
    ----------
    coverage : how many standard uncertainties the columns hold: 2 of an expanded uncertainty, U(95).
    """

    translation: StatedSigma | None = None
    rotation: StatedSigma | None = None
    coverage: Positive = 1.0


class Deflection(Signal):
    """Displacement already taken, loaded minus unloaded.

    Attributes
    ----------
    translation : three columns. rotation : three columns of the rotation vector, where measured.
    body : the frame that moved. axes : the axes the components are in.
    """

    translation: Columns3
    rotation: Columns3 | None = None
    body: Name
    axes: Name = "base"
    units: DeflectionUnits = DeflectionUnits()
    sigma: DeflectionSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"translation": "translation", "rotation": "rotation"}
    look_alikes: ClassVar[dict[str, str]] = {"columns": "translation", "frame": "axes", "position": "translation"}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return self.translation + (self.rotation or ())

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        unit_of_column = dict.fromkeys(self.translation, self.unit_of("translation"))
        return unit_of_column | dict.fromkeys(self.rotation or (), self.unit_of("rotation"))


class Displacement(Signal):
    """A gauge or load-displacement device: the body's displacement along one direction.

    Attributes
    ----------
    column : the reading. body : the frame that is measured. direction : in `axes`, of any length.
    """

    column: Name
    body: Name
    direction: Vector3
    axes: Name = "base"
    units: LengthUnits = LengthUnits()
    sigma: LengthSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"length": "length"}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return (self.column,)

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        return {self.column: self.unit_of("length")}
