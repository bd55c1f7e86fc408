"""The signals a source can hold, as the manifest writes them: columns, units, frames, stated uncertainty."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema, model_validator

from stiffcal.campaign.row_filter import RowCondition, parse_rows
from stiffcal.campaign.typed import (
    AngleUnit,
    Columns,
    Columns3,
    Columns4,
    CurrentUnit,
    ForceUnit,
    LengthUnit,
    MassUnit,
    MomentUnit,
    Name,
    Positive,
    Table,
    TemperatureUnit,
    TimeUnit,
    Vector3,
    VelocityUnit,
    WrongValueError,
    columns_of_count,
)
from stiffcal.quantities import Unit, unit


def _check_rows(text: str) -> str:
    parse_rows(text)
    return text


Rows: TypeAlias = Annotated[str, AfterValidator(_check_rows)]
"""A condition such as ``test_nr < 100``."""


class Signal(Table):
    """What all signals share.

    Attributes
    ----------
    rows : keeps only the rows for which this holds, e.g. ``test_nr < 100``.
    """

    quantity_of: ClassVar[dict[str, str]] = {}
    """Key of `units` to the quantity it is about."""

    rows: Rows | None = None

    @property
    def row_conditions(self) -> tuple[RowCondition, ...]:
        """Return the conditions of `rows`, all of which must hold; empty where none is written."""
        return parse_rows(self.rows) if self.rows is not None else ()

    def unit_of(self, key: str) -> Unit:
        """Return the unit of one of the signal's quantities, as written in `units` or SI.

        Parameters
        ----------
        key : a key of `units`: position, rotation, force, moment, …

        Examples
        --------
        >>> Deflection(translation=("x", "y", "z"), body="tool").unit_of("translation").factor
        1.0
        """
        units: Table = getattr(self, "units")  # noqa: B009  (every concrete signal has its own units table)
        return unit(getattr(units, key), self.quantity_of[key])

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        raise NotImplementedError

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and the unit its numbers are in; columns without a unit are left out."""
        raise NotImplementedError


class JointUnits(Table):
    """Units of a joint log: position deg, rad or rev; velocity; torque; current."""

    position: AngleUnit = "rad"
    velocity: VelocityUnit = "rad/s"
    torque: MomentUnit = "N*m"
    current: CurrentUnit = "A"


class JointSigma(Table):
    """Standard uncertainty of one reading, in the signal's units."""

    position: Positive | None = None
    torque: Positive | None = None
    current: Positive | None = None


def _torque_constants(value: object) -> tuple[float, ...]:
    items: list[Any] = list(value) if isinstance(value, list | tuple) else [value]
    if not items or not all(isinstance(item, int | float) and not isinstance(item, bool) for item in items):
        raise WrongValueError(f"found {value!r}", "write one number in N*m/A, or one per joint")
    return tuple(float(item) for item in items)


TorqueConstants: TypeAlias = Annotated[
    tuple[float, ...],
    BeforeValidator(_torque_constants),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]}),
]


class Joints(Signal):
    """What the controller says of the joints, one column per joint.

    Attributes
    ----------
    position : joint angles. command : commanded angles. velocity, torque, current : likewise.
    torque_constant : N·m per ampere, one for all joints or one each, where `current` is logged.
    motor : the columns are motor-side; gear ratios stand in robot.toml.
    """

    position: Columns | None = None
    command: Columns | None = None
    velocity: Columns | None = None
    torque: Columns | None = None
    current: Columns | None = None
    torque_constant: TorqueConstants | None = None
    units: JointUnits = JointUnits()
    motor: bool = False
    sigma: JointSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {
        "position": "angle", "velocity": "velocity", "torque": "torque", "current": "current",
    }  # fmt: skip
    look_alikes: ClassVar[dict[str, str]] = {"columns": "position", "angles": "position"}

    def groups(self) -> dict[str, tuple[str, ...]]:
        """Return the columns of each quantity that is logged: position, command, velocity, torque, current."""
        keys = ("position", "command", "velocity", "torque", "current")
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return tuple(name for names in self.groups().values() for name in names)

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit; `command` is in the unit of `position`."""
        return {
            name: self.unit_of("position" if key == "command" else key)
            for key, names in self.groups().items()
            for name in names
        }

    @model_validator(mode="after")
    def _something_is_logged(self) -> Joints:
        groups = self.groups()
        if not groups:
            raise WrongValueError("no columns are named", 'write position = ["A1", "A2", …] or position = "A1..A6"')
        counts = {key: len(names) for key, names in groups.items()}
        if len(set(counts.values())) > 1:
            told = ", ".join(f"{count} {key}" for key, count in counts.items())
            raise WrongValueError(f"unequal numbers of columns: {told}", "name one column per joint for each")
        return self


class WrenchUnits(Table):
    """Units of a wrench."""

    force: ForceUnit = "N"
    moment: MomentUnit = "N*m"


class WrenchSigma(Table):
    """Standard uncertainty of one reading, in the signal's units."""

    force: Positive | None = None
    moment: Positive | None = None


class Wrench(Signal):
    """Force, or force and moment.

    Attributes
    ----------
    columns : six (Fx, Fy, Fz, Tx, Ty, Tz), three (force only) or one (force along `direction`).
    frame : short for `axes` and `point` both.
    axes : frame whose axes the components are in.
    point : frame whose origin the moment refers to, or where the force acts.
    direction : of a force of one column, in `axes`.
    acts_on : "robot", or "environment" where the reading is what the robot does to its surroundings.
    tared : zeroed at each "run"'s reference, once per "campaign", or "no".
    """

    columns: Annotated[Columns, AfterValidator(columns_of_count(1, 3, 6))]
    units: WrenchUnits = WrenchUnits()
    frame: Name | None = None
    axes: Name | None = None
    point: Name | None = None
    direction: Vector3 | None = None
    acts_on: Literal["robot", "environment"] = "robot"
    tared: Literal["run", "campaign", "no"] = "run"
    sigma: WrenchSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"force": "force", "moment": "moment"}

    @property
    def axes_frame(self) -> str | None:
        """Frame of the components' axes, None where the manifest leaves it out."""
        return self.axes or self.frame

    @property
    def point_frame(self) -> str | None:
        """Frame whose origin the moment refers to, or where the force acts."""
        return self.point or self.frame

    @property
    def moments_measured(self) -> bool:
        """True where there are six columns."""
        return len(self.columns) == 6

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return self.columns

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit: three forces, then moments."""
        force, moment = self.unit_of("force"), self.unit_of("moment")
        return {name: force if k < 3 else moment for k, name in enumerate(self.columns)}


class PoseUnits(Table):
    """Units of a pose; `rotation` is for rotvec and rpy."""

    position: LengthUnit = "m"
    rotation: AngleUnit = "rad"


class PoseSigma(Table):
    """Standard uncertainty of one reading: position in its unit, rotation in its unit (rad beside a quaternion)."""

    position: Positive | None = None
    rotation: Positive | None = None


class Marker(Table):
    """One of several points on a body.

    Attributes
    ----------
    columns : its three coordinates; empty or NaN while it is hidden.
    at_m : its place on the body, m; left out where a frame of the same name says it.
    """

    columns: Columns3
    at_m: Vector3 | None = None


def _marker(value: object) -> object:
    return {"columns": value} if isinstance(value, list | tuple | str) else value


MarkerEntry: TypeAlias = Annotated[Marker, BeforeValidator(_marker)]


class Pose(Signal):
    """Position and, where measured, orientation of one body.

    Attributes
    ----------
    frame : the instrument's frame. body : the frame or link that is measured.
    position : three columns. quaternion_wxyz, rotvec or rpy (fixed x, y, z): the orientation's columns.
    markers : instead of `position`: name to three columns, or to { columns, at_m }.
    """

    frame: Name = "base"
    body: Name | None = None
    position: Columns3 | None = None
    quaternion_wxyz: Columns4 | None = None
    rotvec: Columns3 | None = None
    rpy: Columns3 | None = None
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
        for key in ("quaternion_wxyz", "rotvec", "rpy"):
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
        found = dict.fromkeys(self.position or marked, length)
        if self.orientation is not None and self.orientation[0] != "quaternion_wxyz":
            found.update(dict.fromkeys(self.orientation[1], rotation))
        return found

    @model_validator(mode="after")
    def _one_way(self) -> Pose:
        written = [key for key in ("quaternion_wxyz", "rotvec", "rpy") if getattr(self, key) is not None]
        if len(written) > 1:
            raise WrongValueError(f"the orientation is written twice, as {' and '.join(written)}", "keep one of them")
        if (self.position is None) == (not self.markers):
            raise WrongValueError("a pose needs either position or markers", 'write position = ["X", "Y", "Z"]')
        if self.markers and len(self.markers) < 3:
            raise WrongValueError(f"{len(self.markers)} markers do not give a pose", "name three or more")
        if self.markers and written:
            raise WrongValueError(f"markers give the orientation, and {written[0]} too", "keep one of them")
        return self


class LengthUnits(Table):
    """Unit of lengths."""

    length: LengthUnit = "m"


class LengthSigma(Table):
    """Standard uncertainty of one reading, in the signal's unit."""

    length: Positive | None = None


class Lengths(Signal):
    """Length changes of integral deformation sensors; each column is a rod under `[ids]`."""

    columns: Columns
    units: LengthUnits = LengthUnits()
    sigma: LengthSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"length": "length"}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return self.columns

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        return dict.fromkeys(self.columns, self.unit_of("length"))


class DeflectionUnits(Table):
    """Units of a displacement already taken."""

    translation: LengthUnit = "m"
    rotation: AngleUnit = "rad"


class DeflectionSigma(Table):
    """Standard uncertainty of one reading, in the signal's units."""

    translation: Positive | None = None
    rotation: Positive | None = None


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
        found = dict.fromkeys(self.translation, self.unit_of("translation"))
        return found | dict.fromkeys(self.rotation or (), self.unit_of("rotation"))


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


class TemperatureUnits(Table):
    """Unit of temperatures."""

    temperature: TemperatureUnit = "K"


class Temperature(Signal):
    """Temperatures, one column per sensor."""

    columns: Columns
    units: TemperatureUnits = TemperatureUnits()

    quantity_of: ClassVar[dict[str, str]] = {"temperature": "temperature"}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return self.columns

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        return dict.fromkeys(self.columns, self.unit_of("temperature"))


class HoldUnits(Table):
    """Unit of hold times."""

    time: TimeUnit = "s"


class Hold(Signal):
    """Time since the load was reached."""

    column: Name
    units: HoldUnits = HoldUnits()

    quantity_of: ClassVar[dict[str, str]] = {"time": "time"}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return (self.column,)

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        return {self.column: self.unit_of("time")}


class MassUnits(Table):
    """Unit of masses."""

    mass: MassUnit = "kg"


class MassSigma(Table):
    """Standard uncertainty of one mass, in the signal's unit."""

    mass: Positive | None = None


class DeadWeight(Signal):
    """A known mass hung on as the load: mass × gravity at `point`."""

    mass_column: Name
    point: Name
    units: MassUnits = MassUnits()
    sigma: MassSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {"mass": "mass"}

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return (self.mass_column,)

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit."""
        return {self.mass_column: self.unit_of("mass")}
