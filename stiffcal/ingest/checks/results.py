"""What `check` answers: what was understood of a campaign, and what is still missing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
from stiffcal.documents import NOT_IN_DOCUMENT, NOT_PROMISED, CommandResult, KeyIf, Number, OrAbsent
from stiffcal.identification.answers.observability import ObservabilityIndices
from stiffcal.ingest.proposals import ProposedSource
from stiffcal.planning.rod_views import CheckedRods
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.registration.frames import RegistrationSummary


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedColumn:
    """A column of a log."""

    signal: str
    """What it measures, as the manifest names signals."""
    column: str
    """Its name in the log."""
    unit: str
    """That it is written in."""
    low_si: Number
    """Its smallest value, SI."""
    high_si: Number
    """Its largest value, SI."""
    moved: bool
    """Whether the two differ."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedSource:
    """A log as it was understood; tables of states have no rate, span and gap."""

    source: str
    """Its name in the manifest."""
    file: str
    """As named in the manifest."""
    rows: int
    """Rows of data."""
    rate_hz: Annotated[Number, KeyIf("sampled")] = None
    """Samples per second."""
    span_s: Annotated[Number, KeyIf("sampled")] = None
    """From the first sample to the last."""
    longest_gap_s: Annotated[Number, KeyIf("sampled")] = None
    """Between two samples."""
    columns: list[CheckedColumn]
    """Each column that was read."""
    sampled: Annotated[bool, NOT_IN_DOCUMENT]
    """Whether its rows were read one after the other in time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedRun:
    """A run, and how much was understood of it."""

    id: str
    """Its name."""
    experiment: str
    """The kind of experiment."""
    n_states: int
    """How many load states are used."""
    n_readings: OrAbsent[int] = None
    """How many readings of another experiment it gave."""
    set_aside: list[str]
    """Load states or pieces that are not used, and why."""
    largest_force_N: Number
    """Null without load states."""
    work_J: Annotated[Number, NOT_PROMISED] = None
    """What the load has done on the robot."""
    clock_ahead_s: Annotated[dict[str, SourceClockOffset], NOT_PROMISED]
    """Of each source, against the first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedKinematics:
    """How far the target is from where the robot file has it, in the reference states."""

    median_m: Number
    """Of the places of the target."""
    worst_m: Number
    """Largest of them."""
    orientation_rad: Number
    """Median of the turns; null where only places were measured."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedJoint:
    """How well a joint can be identified from what has been measured so far."""

    joint: str
    """Its name."""
    largest_torque_Nm: Number
    """That loads put on it; of a prismatic joint the force along its axis, N."""
    expected_relative_std: Number
    """Expected standard uncertainty of its stiffness, of the stiffness."""
    says: str
    """The same in words."""
    prismatic: OrAbsent[bool] = None
    """True of a prismatic joint; absent of others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedNoise:
    """From what the noise of absolute poses is known."""

    source: Literal["manifest", "repeats", "none"]
    """`sigma` of campaign.toml, repeated rows (or repeated loads of load runs), or nothing."""
    n_pairs: int
    """Rows that repeat an earlier one: joints within 0.1°, the same load."""
    rms_m: Number
    """Rms distance that the noise alone makes, √3 times the standard uncertainty of one axis; null where not known."""
    says: str
    """The same in words, with what cannot be judged without it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckResult(CommandResult):
    """Answer of ``check``."""

    schema: Literal["stiffcal/check/1"] = "stiffcal/check/1"
    campaign: str
    """The campaign's name."""
    sources: list[CheckedSource]
    """Every log that was read."""
    runs: list[CheckedRun]
    """Every run that was understood."""
    kinematics: CheckedKinematics | None
    """Whether kinematics and tracker agree; null without poses."""
    n_states: int
    """How many load states are used."""
    rods: OrAbsent[list[CheckedRods]] = None
    """By link, where rods lie on links."""
    registration: Annotated[OrAbsent[RegistrationSummary], NOT_PROMISED] = None
    """Frames that were found from the unloaded poses."""
    joints: OrAbsent[list[CheckedJoint]] = None
    """How well each joint can be identified; not with --quick."""
    noise: OrAbsent[CheckedNoise] = None
    """From what the noise of absolute poses is known; absent without absolute poses."""
    observability: OrAbsent[ObservabilityIndices] = None
    """How well poses of absolute poses determine the model's parameters."""
    suspects: OrAbsent[list[Suspect]] = None
    """Runs and rows that disagree with all the others; not with --quick."""
    suspects_not_checked: OrAbsent[RunsNotChecked] = None
    """What was not compared with the other runs, and why, where there is anything."""
    proposals: OrAbsent[list[ProposedSource]] = None
    """Logs that the manifest does not name, where there are any."""
    ready: bool
    """Whether nothing is missing."""
    missing: list[str]
    """What is still to be measured or written."""
    states_report: Annotated[bool, NOT_IN_DOCUMENT] = True
    """Whether campaign.toml has a [report], be it an empty one."""
