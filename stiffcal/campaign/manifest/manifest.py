"""campaign.toml, typed: what was measured, with which instruments, in which frames.

The keys are those of the interface description; a key that is not known is refused. What cannot be checked in one table
alone (frames that do not exist, files that are missing) is checked in `stiffcal.campaign.checks.together`.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from stiffcal.campaign.found.experiment_kinds import kind_names
from stiffcal.campaign.found.registered import OneOf
from stiffcal.campaign.manifest.report_settings import ReportSettings
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.manifest.thresholds import Thresholds
from stiffcal.campaign.manifest.trend_settings import TrendSettings
from stiffcal.campaign.robot.sizes import Mass, PlaceOnRobot
from stiffcal.campaign.signals.row_filter import ExcludedRows, check_excluded, count_of_rows
from stiffcal.campaign.signals.signals import Signal
from stiffcal.campaign.toml.typed import Counting, Name, Pair, Placement, TomlTable, WrongValueError


class Frame(Placement):
    """A rigid transform from `parent`: "base", "flange", a link's name or another frame.

    Attributes
    ----------
    estimate : found from the unloaded poses; what is written is then the start.
    sigma_m : standard uncertainty of each coordinate of a payload's frame, in campaigns with absolute runs:
        the fit finds its place within it.
    level : its z axis points up, against gravity: of an instrument that was levelled. Its estimate keeps that.
    """

    parent: Name
    estimate: bool = False
    level: bool = False
    sigma_m: Annotated[float, Field(gt=0.0, le=1.0)] | None = None

    look_alikes: ClassVar[dict[str, str]] = {"sigma": "sigma_m"}


class Tool(TomlTable):
    """What is mounted on the flange, for its weight: mass and centre of mass in the flange frame."""

    mass_kg: Mass
    com_m: PlaceOnRobot = (0.0, 0.0, 0.0)

    look_alikes: ClassVar[dict[str, str]] = {"mass": "mass_kg", "com": "com_m"}


class Rod(TomlTable):
    """An integral deformation sensor: a rod along a link.

    Attributes
    ----------
    link : the link's name. start_m, end_m : where the rod is fixed, in the link's beam frame at its inboard end.
    warping_m2 : the warping function at start and end, where it is known and robot.toml draws no section.
    expansion_per_K : the rod's own thermal expansion; with the link's in robot.toml and a logged temperature the
        difference of the two is taken out of its readings.
    """

    link: Name
    start_m: PlaceOnRobot
    end_m: PlaceOnRobot
    warping_m2: Pair | None = None
    expansion_per_K: float | None = Field(None, ge=-1e-4, le=1e-3)


def _are_numbers(items: object, count: int) -> bool:
    if not isinstance(items, list | tuple) or len(items) != count:
        return False
    return all(isinstance(item, int | float) and not isinstance(item, bool) for item in items)


def _compliance(value: object) -> tuple[tuple[float, ...], ...]:
    """Read six numbers (a diagonal) or six rows of six."""
    rows: list[Any] = list(value) if isinstance(value, list | tuple) else []
    if _are_numbers(rows, 6):
        return tuple(tuple(float(rows[i]) if i == j else 0.0 for j in range(6)) for i in range(6))
    if len(rows) == 6 and all(_are_numbers(row, 6) for row in rows):
        return tuple(tuple(float(item) for item in row) for row in rows)
    raise WrongValueError("neither six numbers nor six rows of six", "write the diagonal or the 6×6 matrix")


_NUMBER = {"type": "number"}
_SIX = {"type": "array", "items": _NUMBER, "minItems": 6, "maxItems": 6}
Compliance: TypeAlias = Annotated[
    tuple[tuple[float, ...], ...],
    BeforeValidator(_compliance),
    WithJsonSchema({"anyOf": [_SIX, {"type": "array", "items": _SIX, "minItems": 6, "maxItems": 6}]}),
]


class Run(TomlTable):
    """One run: the files of each source, and what is particular to it.

    Attributes
    ----------
    id : unique name. experiment : what kind of run it is. files : source to file.
    clock_ahead_s : source to the seconds its clock shows more than the first source's; estimated where absent.
    joints_deg : nominal configuration. moved_joint : from 1 (clamped, friction).
    holdout : never used to fit. tags : free words. states : table of the holds (columns start, end, s).
    reference : which state is the reference, from 1. fixture_compliance : m/N and rad/(N·m), base axes (clamped).
    compensation : "on" where the controller was correcting.
    approach : "direct" where the robot went from each row straight to the next (absolute): the joint angles then show
        in which direction each joint moved last, and what it carried before.
    """

    id: Name
    experiment: Annotated[str, OneOf(kind_names)] = "load"
    files: dict[str, Name] = Field(default_factory=dict)
    clock_ahead_s: dict[str, float] = Field(default_factory=dict)
    joints_deg: Annotated[tuple[float, ...], Field(strict=False)] | None = None
    moved_joint: Counting | None = None
    holdout: bool = False
    tags: Annotated[tuple[str, ...], Field(strict=False)] = ()
    states: Name | None = None
    reference: Counting = 1
    fixture_compliance: Compliance | None = None
    compensation: Literal["on", "off"] = "off"
    approach: Literal["direct"] | None = None

    look_alikes: ClassVar[dict[str, str]] = {"name": "id", "file": "files", "clock_ahead": "clock_ahead_s"}

    def options_of(self, kind: str) -> dict[str, object]:
        """Return the options that are written for a kind of experiment, empty where none are."""
        return self.options_under(kind)


class Exclusion(TomlTable):
    """Data rows that are left out, counted from 1 without the header, and why.

    Attributes
    ----------
    source : the source. rows : row numbers, and ranges of them as text, ``[3, "501-540"]``. why : the reason.
    run : the run, where each run has its own file.
    """

    source: Name
    rows: ExcludedRows
    why: Name
    run: Name | None = None


class Manifest(TomlTable):
    """campaign.toml.

    Attributes
    ----------
    name : the folder's name where left out. robot : path of the robot file, inside the campaign folder.
    frames, tool, sources, ids, runs, exclude, thresholds, report, trend, plugins : see their types.
    """

    schema_id: Literal["stiffcal/campaign/1"] = Field(alias="schema")
    name: Name | None = None
    robot: Name = "robot.toml"
    frames: dict[str, Frame] = Field(default_factory=dict)
    tool: Tool | None = None
    sources: dict[str, Source] = Field(default_factory=dict)
    ids: dict[str, Rod] = Field(default_factory=dict)
    runs: Annotated[tuple[Run, ...], Field(strict=False)] = ()
    exclude: Annotated[tuple[Exclusion, ...], Field(strict=False)] = ()
    thresholds: Thresholds = Thresholds()
    report: ReportSettings = ReportSettings()
    trend: TrendSettings = TrendSettings()
    plugins: Annotated[tuple[str, ...], Field(strict=False)] = ()

    run_type: ClassVar[type[Run]] = Run

    look_alikes: ClassVar[dict[str, str]] = {
        "run": "runs",
        "rows": "sources.NAME.rows",
        "source": "sources",
        "frame": "frames",
        "threshold": "thresholds",
    }

    @model_validator(mode="before")
    @classmethod
    def _check_rows_left_out(cls, document: Any) -> Any:
        """Count the rows that all excludes name together, before each of them becomes a list."""
        entries = document.get("exclude") if isinstance(document, dict) else None
        if isinstance(entries, list):
            check_excluded(sum(count_of_rows(entry.get("rows")) for entry in entries if isinstance(entry, dict)))
        return document

    def signals(self) -> list[tuple[str, str, Signal]]:
        """Return every signal as (source, signal name, signal), in the order of the file."""
        return [
            (source, name, signal)
            for source, settings in self.sources.items()
            for name, signal in settings.signals().items()
        ]

    def files_of(self, source: str, run: Run | None = None) -> dict[str, str]:
        """Return the files of a source in a run, by signal name; ``""`` stands for a file that holds all signals.

        Examples
        --------
        >>> document = {"schema": "stiffcal/campaign/1", "sources": {"ft": {"file": "a.csv"}}}
        >>> Manifest.model_validate(document).files_of("ft")
        {'': 'a.csv'}
        """
        settings = self.sources[source]
        if run is not None and source in run.files:
            return {"": run.files[source]}
        return dict(settings.files) if settings.files else ({"": settings.own_file} if settings.own_file else {})
