"""`simulate.toml`: what a simulated campaign does with its robot, and how its instruments err. SI units throughout.

What the logs look like (files, formats, columns, units) is *not* stated here: `campaign.toml` states it already, and
`simulate` writes exactly what the manifest promises to read.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, cast

from pydantic import BeforeValidator, Field, WithJsonSchema, create_model, model_validator

from stiffcal.campaign.toml.reach import check_own
from stiffcal.campaign.toml.toml_reading import read_toml, validate
from stiffcal.campaign.toml.typed import Interval, NotNegative, Placement, Positive, TomlTable, WrongValueError
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.simulation.motion_tables import motion_tables

SCHEMA = "stiffcal/simulate/1"
FILE_NAME = "simulate.toml"


def _direction(value: object) -> object:
    """Check that a direction is three or six numbers and pulls somewhere."""
    if not isinstance(value, list | tuple) or len(value) not in (3, 6):
        raise WrongValueError(f"found {value!r}", "write three numbers, or six with the moment per newton")
    if all(isinstance(component, int | float) for component in value) and not any(value[:3]):
        raise WrongValueError("the direction of no force", "write where the force points, e.g. [0, 0, -1]")
    return list(value)


_NUMBERS = {"type": "array", "items": {"type": "number"}}
Direction = Annotated[
    list[float],
    BeforeValidator(_direction),
    WithJsonSchema({"anyOf": [{**_NUMBERS, "minItems": count, "maxItems": count} for count in (3, 6)]}),
]


class Amounts(TomlTable):
    """An amount per axis for each quantity that an instrument may read; zero where it is not stated."""

    force_N: NotNegative = 0.0
    moment_Nm: NotNegative = 0.0
    translation_m: NotNegative = 0.0
    rotation_rad: NotNegative = 0.0
    angle_rad: NotNegative = Field(0.0, description="logged joint angles")
    temperature_K: NotNegative = 0.0
    length_m: NotNegative = Field(0.0, description="rods on links")
    velocity_rad_s: NotNegative = Field(0.0, description="logged joint or motor velocities")
    torque_Nm: NotNegative = Field(0.0, description="logged motor torques, on the side that is logged")
    current_A: NotNegative = Field(0.0, description="logged motor currents")


class Bumps(TomlTable):
    """Readings spoilt by a knock against the instrument: whole holds, picked by the seed."""

    per_run: int = Field(0, ge=0, description="spoilt dwells in each run")
    size: Amounts = Field(Amounts(), description="length of the error, in a direction drawn for each")


class Sensor(TomlTable):
    """How one source (logging device) errs: noise, clock, log."""

    rate_hz: Positive | None = Field(None, description="samples per second; needed where the log is over time")
    clock: Literal["restarts", "runs on"] = Field(
        "restarts", description="each log starts at its clock's zero, or the clock runs on over the whole campaign"
    )
    clock_ahead_s: float = Field(0.0, description="a clock that runs on shows this much more than the true time")
    clock_drift_ppm: float = Field(0.0, description="how much too fast the clock runs")
    starts_before_s: Interval = Field(
        (0.5, 3.0), description="the log starts this long before the first dwell (drawn from the range)"
    )
    white: Amounts = Field(Amounts(), description="standard deviation of single readings within a hold")
    between_holds: Amounts = Field(Amounts(), description="standard deviation, constant within a hold")
    readings_per_hold: int = Field(1, ge=1, description="states tables only: readings averaged into one row")
    zero: Amounts = Field(
        Amounts(), description="standard deviation of what is shown at a run's start: a zero set badly"
    )
    drift_per_hour: Amounts = Field(Amounts(), description="drift, along a direction drawn once per campaign")
    saturation: Amounts = Field(Amounts(), description="readings are cut off at this size per axis; 0: never")
    resolution: Amounts = Field(Amounts(), description="readings come in steps of this size; 0: none")
    bumps: Bumps = Bumps()
    hidden: float = Field(0.0, ge=0.0, lt=1.0, description="markers: share of the dwells in which each is out of sight")
    starts_anew: bool = Field(False, description="motor angles are logged within one turn, −180° to 180°")
    preamble: list[str] = Field([], description="lines before a text log's column names; as many as skip_rows")
    decimals: dict[str, int] = Field({}, description="decimals written, by column name; else 6 (time 4)")


class Loads(TomlTable):
    """One run's load cycles. A force (and moment) that keeps its direction in the base and its place on the robot."""

    point: str = Field("load_point", description="the frame in which the load acts")
    axes: str = Field("base", description="frame whose axes the directions are in, before any load")
    directions: list[Direction] = Field(
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        description="of the force, scaled to length 1; three more numbers: the moment per newton, m",
    )
    max_force_N: Positive = 400.0
    levels: Annotated[list[Positive], Field(min_length=1)] = Field(
        [0.25, 0.5, 0.75, 1.0], description="of the largest force, rising"
    )
    both_ways: bool = Field(True, description="after unloading, the same against the direction")
    cycles: int = Field(1, ge=1, description="full cycles in each direction")
    level_scatter: NotNegative = Field(0.02, description="loads are never hit exactly: standard deviation, relative")
    direction_scatter_rad: NotNegative = Field(0.005, description="nor is the direction: standard deviation")
    first_hold_s: Positive = Field(4.0, description="unloaded at the start")
    hold_s: Positive = Field(3.0, description="a load is held, after it has settled")
    hold_scatter: NotNegative = Field(0.0, description="standard deviation of that time, relative")
    ramp_s: Positive = Field(0.8, description="from one load to the next")
    ramp_scatter: NotNegative = Field(0.15, description="standard deviation of that time, relative")
    settle_s: NotNegative = Field(0.6, description="after the ramp until the load has settled; eight time constants")
    ramp_points: int = Field(2, ge=0, description="balances solved on each ramp, between its ends")
    waviness: NotNegative = Field(
        0.0, description="friction of the device makes the load lead and lag on a ramp, by this share of the step"
    )
    waves: int = Field(6, ge=1, description="so often on each ramp")
    hold_points: int = Field(1, ge=1, description="balances solved in each hold; 3 or more for robots that creep")
    guide_N_per_m: NotNegative = Field(
        0.0, description="side force on a tool that is held across the load, per displacement (a drill in its hole)"
    )

    @model_validator(mode="after")
    def _does_not_run_back(self) -> Loads:
        most = 1.0 / (2.0 * math.pi * self.waves)
        if self.waviness > most:
            raise WrongValueError(
                f"waviness {self.waviness:g} with {self.waves} waves makes the load run back on its ramp",
                f"with so many waves it is {math.floor(1e3 * most) / 1e3:g} at most",
            )
        return self


class Controller(TomlTable):
    """How the controller corrects in runs with ``compensation = "on"`` in campaign.toml (001, Fig. 3; 002, Fig. 5)."""

    cycle_s: Positive = Field(0.004, description="from one reading to the next, 1 to 4 ms in published controllers")
    delay_s: NotNegative = Field(0.0, description="from the reading until the robot has moved")
    filter_hz: Positive | None = Field(None, description="cut-off of the low-pass for the force; left out: none")
    effects: list[str] = Field(
        ["joint-compliance"], description="what the controller's model holds of model.toml's effects"
    )
    parameters: dict[str, float] = Field(
        {}, description="values that it takes for true, by full name; the others it knows as they are"
    )


class RunHead(TomlTable):
    """What stands first in a run."""

    id: str = Field(description="the run's id in campaign.toml")
    joints_deg: Annotated[list[float], Field(min_length=1)] = Field(
        description="logged joint angles; of prismatic joints positions, mm"
    )
    loads: dict[str, Any] = Field({}, description="keys of [loads] that differ in this run")


class SimulatedRun(RunHead):
    """One run; `settings_type` adds the tables of kinds of experiment."""

    pause_before_s: NotNegative = Field(300.0, description="time between the run before and this one")

    def changed(self, table: str) -> dict[str, Any]:
        """Return the keys of a table that differ in this run."""
        return dict(getattr(self, table, {}))


class TrueRobot(TomlTable):
    """What the robot has beyond robot.toml and model.toml."""

    position_error_m: NotNegative = Field(
        0.0,
        description="standard deviation per axis of the absolute position: constant in a run, absent in deflection",
    )
    orientation_error_rad: NotNegative = 0.0
    geometry_error_m: NotNegative = Field(
        0.0,
        description="standard deviation of the axes' shifts to which model.toml gives no value (link-geometry);"
        " 0: each needs a value",
    )
    geometry_error_rad: NotNegative = Field(0.0, description="the same of the axes' tilts and the joints' zeros")
    temperature_C: float = 22.0
    warming_K_per_hour: float = 0.0
    hidden: list[str] = Field(
        [], description="effects of model.toml that the simulated campaign's model.toml leaves out, to be found"
    )


class SettingsHead(TomlTable):
    """What stands first in `simulate.toml`."""

    schema_: Literal["stiffcal/simulate/1"] = Field(alias="schema")
    seed: int = Field(0, ge=0, description="the option --seed overrides it")
    loads: Loads = Loads()


class SimulationSettings(SettingsHead):
    """`simulate.toml` in full; `settings_type` adds the tables of kinds of experiment."""

    robot: TrueRobot = TrueRobot()
    controller: Controller = Controller()
    frames: dict[str, Placement] = Field({}, description="[frames.NAME]: true places, by the manifest's names")
    sensors: dict[str, Sensor] = Field({}, description="[sensors.NAME], by the manifest's source names")
    runs: Annotated[list[SimulatedRun], Field(min_length=1)]

    def loads_of(self, run: SimulatedRun) -> Loads:
        """Return the load cycles of a run: `[loads]` with what the run changes."""
        return Loads.model_validate({**self.loads.model_dump(), **run.loads})

    def motion_of(self, kind: str, run: SimulatedRun) -> TomlTable:
        """Return the motion of a run of a kind of experiment: the kind's table with what the run changes."""
        table: TomlTable = getattr(self, kind)
        return type(table).model_validate({**table.model_dump(), **run.changed(kind)})

    def sensor(self, source: str) -> Sensor:
        """Return the errors of a source; without an entry: none."""
        return self.sensors.get(source, Sensor())


@cache
def _settings_type(tables: tuple[tuple[str, type[TomlTable]], ...]) -> type[SimulationSettings]:
    # The kinds' tables lie between head and rest, so that keys and faults come in the order in which people write them.
    changed: dict[str, Any] = {
        name: (dict[str, Any], Field({}, description=f"keys of [{name}] that differ in this run")) for name, _ in tables
    }
    names = ["`[loads]`", *(f"`[{name}]`" for name, _ in tables)]
    text = f"{', '.join(names[:-1])} or {names[-1]}" if len(names) > 1 else names[0]
    bases: Any = (SimulatedRun, create_model("RunTables", __base__=RunHead, **changed))
    doc = f"One run: where the robot stands, and what differs from {text}."
    run: Any = create_model("SimulatedRun", __base__=bases, __doc__=doc)
    own: dict[str, Any] = {name: (table, table()) for name, table in tables}
    bases = (SimulationSettings, create_model("SettingsTables", __base__=SettingsHead, **own))
    runs: Any = (Annotated[list[run], Field(min_length=1)], ...)
    made = create_model("SimulationSettings", __base__=bases, __doc__="`simulate.toml` in full.", runs=runs)
    return cast(type[SimulationSettings], made)


def settings_type() -> type[SimulationSettings]:
    """Return the type that `simulate.toml` is checked against: with the tables of all kinds of experiment.

    Examples
    --------
    >>> list(settings_type().model_fields)[:5]
    ['schema_', 'seed', 'loads', 'absolute', 'clamped']
    """
    return _settings_type(motion_tables())


def load_settings(folder: Path) -> SimulationSettings:
    """Read `simulate.toml` of a folder.

    Raises
    ------
    InputError
        where the file is missing or wrong: every fault, with its place.
    """
    check_own(folder, FILE_NAME)
    return parse_settings(read_toml(folder / FILE_NAME, FILE_NAME))


def parse_settings(document: dict[str, Any]) -> SimulationSettings:
    """Check a document as read from `simulate.toml`.

    Raises
    ------
    InputError
        with one fault for each key that is wrong.

    Examples
    --------
    >>> settings = parse_settings({"schema": "stiffcal/simulate/1", "runs": [{"id": "a", "joints_deg": [0.0]}]})
    >>> settings.loads_of(settings.runs[0]).levels
    [0.25, 0.5, 0.75, 1.0]
    """
    settings = validate(document, FILE_NAME, settings_type())
    faults: list[Fault] = []
    run_names: set[str] = set()
    for run in settings.runs:
        place = f'runs "{run.id}"'
        if run.id in run_names:
            faults.append(
                Fault(FaultCode.NAME_DUPLICATE, FILE_NAME, place, "there are two runs of this name", "rename one")
            )
        run_names.add(run.id)
        tables: tuple[tuple[str, type[TomlTable]], ...] = (("loads", Loads), *motion_tables())
        for key, table in tables:
            try:
                validate({**document.get(key, {}), **run.changed(key)}, FILE_NAME, table)
            except InputError as error:
                faults += [
                    Fault(fault.code, FILE_NAME, f"{place}: {key}.{fault.place}", fault.reason, fault.mend)
                    for fault in error.faults
                ]
    raise_faults(faults)
    return settings
