"""Sources of campaign.toml: where the files of a logging device are, how they are read, which signals they hold."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from stiffcal.campaign.found.file_formats import format_names, format_of, log_format
from stiffcal.campaign.found.registered import OneOf
from stiffcal.campaign.manifest.file_patterns import RUN, FilePattern
from stiffcal.campaign.signals.row_filter import RowCondition, parse_rows
from stiffcal.campaign.signals.signal import Rows
from stiffcal.campaign.signals.signals import (
    DeadWeight,
    Deflection,
    Displacement,
    Hold,
    JointSignals,
    Lengths,
    Pose,
    Signal,
    Temperature,
    Wrench,
)
from stiffcal.campaign.toml.typed import Name, Positive, TimeUnit, TomlTable, WrongValueError
from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import UnknownUnitError, unit, unit_names

SIGNAL_NAMES = (
    "joints",
    "wrench",
    "dead_weight",
    "pose",
    "deflection",
    "displacement",
    "lengths",
    "temperature",
    "hold",
)


TIMES_IN_WORDS = ("iso8601", "day-first", "month-first")
"""Units of times that are no numbers: dates, with the order of day and month where the year stands last."""


def _time_unit(name: str) -> str:
    if name in TIMES_IN_WORDS:
        return name
    try:
        return unit(name, "time").name
    except UnknownUnitError as error:
        mend = f"{error.mend}, or of dates {', '.join(TIMES_IN_WORDS)}"
        raise WrongValueError(error.reason, mend, FaultCode.UNIT_UNKNOWN) from error


LogTimeUnit: TypeAlias = Annotated[
    str,
    AfterValidator(_time_unit),
    WithJsonSchema({"type": "string", "examples": [*unit_names("time"), *TIMES_IN_WORDS]}),
]


class TimeAxis(TomlTable):
    """The time of each row: a column with its unit, or a rate where rows come evenly.

    Attributes
    ----------
    fraction : a column of what is added to the first one's time, as nanoseconds next to seconds.
    fraction_unit : its unit.
    """

    column: Name | None = None
    unit: LogTimeUnit | None = None
    rate_hz: Positive | None = None
    fraction: Name | None = None
    fraction_unit: TimeUnit | None = None

    @property
    def in_words(self) -> bool:
        """True where the column holds dates or times of day instead of numbers."""
        return self.unit in TIMES_IN_WORDS

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that are read: of the time, and of its fraction."""
        return tuple(name for name in (self.column, self.fraction) if name is not None)

    @property
    def date_order(self) -> str:
        """The order of day and month in dates, "" where it is not stated."""
        return self.unit if self.unit is not None and self.unit in TIMES_IN_WORDS[1:] else ""

    @model_validator(mode="after")
    def _one_way(self) -> TimeAxis:
        if (self.column is None) == (self.rate_hz is None):
            raise WrongValueError(
                "time needs a column or a rate", 'write { column = "t", unit = "s" } or { rate_hz = 5000 }'
            )
        if self.column is not None and self.unit is None:
            raise WrongValueError(
                f'the unit of the time column "{self.column}" is missing',
                'add unit = "s", "ms", "us", "ns" or "iso8601"',
            )
        if self.column is None and self.unit is not None:
            raise WrongValueError("a rate needs no unit", "remove unit")
        if (self.fraction is None) != (self.fraction_unit is None):
            raise WrongValueError(
                "fraction and fraction_unit belong together", 'write fraction = "nanosec", fraction_unit = "ns", say'
            )
        if self.fraction is not None and self.column in (None, self.fraction):
            raise WrongValueError("a fraction is added to the time of another column", "name that as column")
        return self


class RunOfRows(TomlTable):
    """Which run a row belongs to: a column that holds the run's name, or each row its own run."""

    column: Name | None = None
    each: Literal["row"] | None = None

    @model_validator(mode="after")
    def _one_way(self) -> RunOfRows:
        if (self.column is None) == (self.each is None):
            raise WrongValueError("run needs one of column and each", 'write { column = "run" } or { each = "row" }')
        return self


class SourceFiles(TomlTable):
    """Where the files of a logging device are, and how they are read; see `Source`.

    `stiffcal.campaign.manifest.manifest_type` adds the tables of options that log formats have.
    """

    format: Annotated[str, OneOf(format_names)] | None = None
    sampling: Literal["time", "states"] | None = None
    file: Name | None = None
    files: dict[str, Name] = Field(default_factory=dict)
    run: RunOfRows | None = None
    time: TimeAxis | None = None
    rows: Rows | None = None


class Source(SourceFiles):
    """One logging device: where its files are, how they are read, and the signals they hold.

    Attributes
    ----------
    format : from the file's ending where left out.
    sampling : "time": logged at a rate; "states": one row per averaged load state. Left out: states where `run` stands.
    file : one file for all runs; of a database its table or query. With ``{run}`` in it, the pattern of each run's
        file, ``raw/{run}_force.csv``, in which ``*`` stands for text that differs and does not count.
    files : signal name to file, where the columns lie in several files of equal length.
    run : which run each row belongs to. time : optional for states.
    rows : keeps only the rows for which this holds, for all of the source's signals, e.g. ``X > -100``.
    """

    joints: JointSignals | None = None
    wrench: Wrench | None = None
    dead_weight: DeadWeight | None = None
    pose: Pose | None = None
    poses: dict[str, Pose] = Field(default_factory=dict)
    deflection: Deflection | None = None
    displacement: Displacement | None = None
    lengths: Lengths | None = None
    temperature: Temperature | None = None
    hold: Hold | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "joint": "joints", "force": "wrench", "forces": "wrench", "position": "pose", "displacements": "displacement",
    }  # fmt: skip

    def signals(self) -> dict[str, Signal]:
        """Return the signals that the source holds, by name; those under `poses` as ``poses.NAME``, of body NAME."""
        signals: dict[str, Signal] = {}
        for name in SIGNAL_NAMES:
            signal = getattr(self, name)
            if signal is not None:
                signals[name] = signal
            if name == "pose":
                for body, pose in self.poses.items():
                    signals[f"poses.{body}"] = pose if pose.body else pose.model_copy(update={"body": body})
        return signals

    def body_poses(self) -> dict[str, Pose]:
        """Return the measured poses by the frame or link that is measured."""
        poses = {self.pose.body or "target": self.pose} if self.pose is not None else {}
        return poses | {pose.body or name: pose for name, pose in self.poses.items()}

    @model_validator(mode="after")
    def _rows_in_one_file(self) -> Source:
        if self.rows is not None and self.files:
            raise WrongValueError(
                "rows at the source requires a source with one file, and this one has several",
                "write rows at the signal whose file contains the column",
            )
        return self

    @property
    def row_conditions(self) -> tuple[RowCondition, ...]:
        """Return every condition on rows, of the source and of its signals; a row has to meet all of them."""
        own = parse_rows(self.rows) if self.rows is not None else ()
        signals = (condition for signal in self.signals().values() for condition in signal.row_conditions)
        return tuple(dict.fromkeys((*own, *signals)))

    @property
    def is_states(self) -> bool:
        """True where each row is one averaged load state."""
        return self.sampling == "states" or (self.sampling is None and self.run is not None)

    @property
    def pattern(self) -> FilePattern | None:
        """The pattern of each run's file, where `file` is one."""
        return FilePattern(self.file) if self.file is not None and RUN in self.file and self.in_files else None

    @property
    def own_file(self) -> str | None:
        """The file for all runs; None where `file` is the pattern of each run's."""
        return None if self.pattern is not None else self.file

    @property
    def in_files(self) -> bool:
        """False where `file` names a database's table or query."""
        known = log_format(self.format) if self.format is not None else None
        return known is None or known.in_files

    def format_for(self, file: str) -> str | None:
        """Return the format to read `file` with: as written, else by its ending."""
        return self.format or format_of(file)

    def options_of(self, log_format: str) -> dict[str, object]:
        """Return the options that are written for a log format, empty where none are."""
        return self.options_under(log_format)

    def columns(self) -> tuple[str, ...]:
        """Return every column that is read, each once: run, time, then the signals'."""
        names = [self.run.column] if self.run is not None else []
        names += self.time.columns if self.time is not None else ()
        names += [condition.column for condition in self.row_conditions]
        for signal in self.signals().values():
            names += [
                *signal.column_names(),
                *(column for group in signal.sigma_columns().values() for column in group),
            ]
        return tuple(dict.fromkeys(name for name in names if name is not None))
