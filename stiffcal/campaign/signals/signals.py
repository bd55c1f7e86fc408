"""The signals a source can hold, as the manifest writes them: columns, units, frames, stated uncertainty.

Those of what moved are in `stiffcal.campaign.signals.displacement_signals`, and can be had from here too.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema, model_validator

from stiffcal.campaign.signals.displacement_signals import Deflection, Displacement, Lengths, Marker, Pose
from stiffcal.campaign.signals.signal import Signal
from stiffcal.campaign.toml.typed import (
    Columns,
    CurrentUnit,
    ForceUnit,
    JointUnit,
    MassUnit,
    MomentUnit,
    Name,
    Positive,
    TemperatureUnit,
    TimeUnit,
    TomlTable,
    Vector3,
    VelocityUnit,
    WrongValueError,
    columns_of_count,
)
from stiffcal.quantities import Unit, unit, unit_names


class JointUnits(TomlTable):
    """Units of a joint log; `position` is one unit, or one per joint where some are prismatic (mm, m)."""

    position: JointUnit = "rad"
    velocity: VelocityUnit = "rad/s"
    torque: MomentUnit = "N*m"
    current: CurrentUnit = "A"


class JointSigma(TomlTable):
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


class JointSignals(Signal):
    """What the controller logs of the joints, one column per joint.

    Attributes
    ----------
    position : joint angles. command : commanded angles. velocity, torque, current : likewise.
    torque_constant : N·m per ampere, one for all joints or one each, where `current` is logged.
    motor : the columns are motor-side; gear ratios stand in robot.toml.
    torque_gain_sigma : relative standard uncertainty of each motor's torque, its constant and gear in it: the torques
        that hold the robot at rest in absolute runs then count, for the moments of the links (`link-weight`).
    approach : direction of each joint's last motion before a row of an absolute run, in the logged angle's sense: a
        positive or a negative number (a sign, or the motion itself); 0 or empty where it is not known.
    """

    position: Columns | None = None
    command: Columns | None = None
    velocity: Columns | None = None
    torque: Columns | None = None
    current: Columns | None = None
    torque_constant: TorqueConstants | None = None
    approach: Columns | None = None
    units: JointUnits = JointUnits()
    motor: bool = False
    torque_gain_sigma: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    sigma: JointSigma | None = None

    quantity_of: ClassVar[dict[str, str]] = {
        "velocity": "velocity", "torque": "torque", "current": "current",
    }  # fmt: skip
    look_alikes: ClassVar[dict[str, str]] = {"columns": "position", "angles": "position"}

    def groups(self) -> dict[str, tuple[str, ...]]:
        """Return the columns of each quantity that is logged, by its key."""
        keys = ("position", "command", "velocity", "torque", "current", "approach")
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}

    @property
    def has_torque(self) -> bool:
        """True where the motors' torques are logged, or their currents with the constants."""
        return self.torque is not None or (self.current is not None and self.torque_constant is not None)

    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""
        return tuple(name for names in self.groups().values() for name in names)

    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and its unit; `command` is in the unit of `position`, `approach` has none."""
        result: dict[str, Unit] = {}
        for key, names in self.groups().items():
            if key in ("position", "command"):
                result |= dict(zip(names, self.position_units(len(names)), strict=False))
            elif key != "approach":
                result |= dict.fromkeys(names, self.unit_of(key))
        return result

    def length_columns(self) -> frozenset[str]:
        """Return the columns that hold positions of prismatic joints."""
        of_unit = self.columns_with_units()
        return frozenset(name for name, own in of_unit.items() if own.quantity == "length")

    def position_units(self, count: int) -> tuple[Unit, ...]:
        """Return the unit of each of ``count`` columns of positions; fewer where the manifest lists fewer."""
        stated = self.units.position
        names = (stated,) * count if isinstance(stated, str) else stated
        return tuple(unit(name, "length" if name in unit_names("length") else "angle") for name in names)

    @model_validator(mode="after")
    def _something_is_logged(self) -> JointSignals:
        groups = self.groups()
        if not groups:
            raise WrongValueError("no columns are given", 'write position = ["A1", "A2", "A3"] or position = "A1..A6"')
        counts = {key: len(names) for key, names in groups.items()}
        if self.torque_gain_sigma is not None and not self.has_torque:
            raise WrongValueError(
                "torque_gain_sigma without torque columns", "name torque columns, or current and torque_constant"
            )
        if len(set(counts.values())) > 1:
            counted = ", ".join(f"{count} {key}" for key, count in counts.items())
            raise WrongValueError(f"unequal numbers of columns: {counted}", "name one column per joint for each")
        return self


class WrenchUnits(TomlTable):
    """Units of a wrench."""

    force: ForceUnit = "N"
    moment: MomentUnit = "N*m"


class WrenchSigma(TomlTable):
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


class TemperatureUnits(TomlTable):
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


class HoldUnits(TomlTable):
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


class MassUnits(TomlTable):
    """Unit of masses."""

    mass: MassUnit = "kg"


class MassSigma(TomlTable):
    """Standard uncertainty of one mass, in the signal's unit."""

    mass: Positive | None = None


class DeadWeight(Signal):
    """A known mass hung on as the load: mass × gravity at `point`; next to a wrench only compared with it."""

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


__all__ = [
    "DeadWeight",
    "Deflection",
    "Displacement",
    "Hold",
    "JointSignals",
    "Lengths",
    "Marker",
    "Pose",
    "Signal",
    "Temperature",
    "Wrench",
]
