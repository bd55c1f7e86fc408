"""What ``batch`` answers, and what goes between its processes: tasks and outcomes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Final, Literal, TypeAlias

from stiffcal.diagnosis.answers.suspect_results import Suspect
from stiffcal.documents import NOT_PROMISED, CommandResult, Document, Number, OrAbsent, Origin
from stiffcal.errors import Fault
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where
from stiffcal.results.error_result import FaultEntry
from stiffcal.validation.results import ThresholdCheck

CampaignState: TypeAlias = Literal["held", "not held", "broken", "fault", "lost"]
"""Held and not held: its thresholds; broken: its files are wrong; fault: stiffcal's own; lost: its process was ended
each time, or made no progress.
"""
HELD: Final = "held"
NOT_HELD: Final = "not held"
BROKEN: Final = "broken"
FAULT: Final = "fault"
LOST: Final = "lost"
STEPS = ("ingest", "identify", "validate", "report")
IDLE_TIMEOUT_S = 600.0
"""After so long without progress a process is given up, s. The longest that passes without is one call that waits: a
store of 100 MB goes to an object store at 0.2 MB/s in that time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchTask:
    """One campaign that is to be worked through."""

    folder: str
    """The campaign folder."""
    campaign: str
    """How the summary names it."""
    store: str | None = None
    """Address of its store; None: DIR/store."""
    report: bool = True
    """Whether a PDF is made."""
    report_file: str | None = None
    """Where the PDF goes; None: DIR/report.pdf."""
    overwrite: bool = False
    """Whether the PDF may replace a file that holds something stiffcal did not write."""
    thresholds: Document | None = None
    """A file of thresholds, as read; None where there is none."""
    allowed_paths: list[str] = field(default_factory=list)
    """What the user has named: a manifest may point to a baseline in it."""
    idle_timeout_s: float = IDLE_TIMEOUT_S
    """After so long without progress its process is given up, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchStep:
    """A step of a campaign."""

    done: bool
    """Whether it had to be run."""
    why: str
    """Why it was run; "" where nothing had changed."""
    seconds: float
    """How long it took."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifiedStiffness:
    """A stiffness that was identified."""

    name: str
    """Full name of the parameter."""
    where: Where
    """Its effect's place."""
    stiffness: Number
    """One over the compliance; None where these data do not identify it."""
    stiffness_std: Number
    """Its standard uncertainty."""
    shifted: bool | None = None
    """Whether adding what the model lacks moves it beyond its 95 % interval; None where the fit is not diagnosed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AuthorChoice:
    """Something that the author of campaign.toml has left out or asks for."""

    kind: Literal["exclude", "row filter", "holdout", "threshold"]
    """What it does."""
    place: str
    """Where it stands in campaign.toml."""
    text: str
    """What it is, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignOutcome:
    """What came of a campaign; numbers are None where it did not come so far."""

    campaign: str
    """How the summary names it."""
    folder: str
    """The campaign folder."""
    name: str
    """As in campaign.toml; the folder's name where that could not be read."""
    state: CampaignState
    """Whether the thresholds hold, or how the campaign ended."""
    steps: dict[str, BatchStep] = field(default_factory=dict)
    """Those that ended, by name."""
    failed_at: str | None = None
    """The step that was wrong."""
    seconds: float = 0.0
    """How long all steps took."""
    memory_bytes: int | None = None
    """The largest size of its process."""
    n_states: int | None = None
    """Load states that were used."""
    n_runs: int | None = None
    """Runs that were used."""
    rms: Rms | None = None
    """The error in held-out poses."""
    noise: Rms | None = None
    """What the instruments scatter; None where it is not known."""
    relative: Rms | None = None
    """Error over deflection, a share in each measure."""
    stiffness: list[IdentifiedStiffness] = field(default_factory=list)
    """Of the joints and whatever else gives."""
    checks: list[ThresholdCheck] = field(default_factory=list)
    """Every threshold, judged."""
    failed: list[str] = field(default_factory=list)
    """Thresholds that do not hold, in words."""
    not_judged: list[str] = field(default_factory=list)
    """Thresholds that cannot be judged, in words."""
    warnings: list[str] = field(default_factory=list)
    """What a reader of the numbers must know, a line each."""
    suspects: OrAbsent[list[Suspect]] = None
    """Runs and rows that disagree with all the others; only where runs were compared."""
    choices: list[AuthorChoice] = field(default_factory=list)
    """Of the author of campaign.toml."""
    report: str | None = None
    """The PDF."""
    origin: Origin | None = None
    """From whom the numbers come."""
    error: FaultEntry | None = None
    """What was wrong."""
    others: list[FaultEntry] = field(default_factory=list)
    """What else was wrong."""
    generations: Annotated[OrAbsent[list[str]], NOT_PROMISED] = None
    """Digests of the generations that its process has committed to the store."""

    @property
    def unchanged(self) -> bool:
        """Whether nothing had to be computed."""
        return self.error is None and not any(step.done for step in self.steps.values())


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchCounts:
    """How many campaigns ended how."""

    campaigns: int
    """All of them."""
    held: int
    """Those in which every threshold holds."""
    not_held: int
    """Those in which a threshold does not hold."""
    broken: int
    """Those that ended in an error, a fault of the program, or with a lost process."""
    unchanged: int
    """Those in which nothing had to be computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchWorkers:
    """Who has worked."""

    kind: Literal["processes", "dask"]
    """Processes on this machine, or threads of a Dask cluster."""
    count: int
    """How many worked at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchResult(CommandResult):
    """Answer of ``batch``."""

    schema: Literal["stiffcal/batch/1"] = "stiffcal/batch/1"
    passed: bool
    """Whether all campaigns hold."""
    counts: BatchCounts
    seconds: float
    """How long it took."""
    workers: BatchWorkers
    peak_memory_bytes: int | None
    """Of the largest process; None where the system does not provide it."""
    campaigns: list[CampaignOutcome]
    """In the order given."""


def outcome_of(task: BatchTask, state: CampaignState, error: Fault | None = None) -> CampaignOutcome:
    """Return the outcome of a task of which nothing else is known."""
    return CampaignOutcome(
        campaign=task.campaign,
        folder=task.folder,
        name=Path(task.folder).name,
        state=state,
        failed_at=None if error is None else STEPS[0],
        error=None if error is None else FaultEntry.of(error),
    )
