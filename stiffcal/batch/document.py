"""What `batch` answers, typed."""

from __future__ import annotations

from typing import Literal

from typing_extensions import TypedDict

from stiffcal.batch.author_choices import AuthorChoice
from stiffcal.workflow.document_types import FaultEntry, Number, Origin, RmsEntry, Threshold, WhereEntry


class BatchStep(TypedDict):
    """A step of a campaign: whether it had to be run, and why ("" where nothing had changed)."""

    done: bool
    why: str
    seconds: float


class JointStiffness(TypedDict):
    """A stiffness that was found; null where these data cannot tell it."""

    name: str
    where: WhereEntry
    stiffness: Number
    stiffness_std: Number


class BatchCampaign(TypedDict):
    """What came of a campaign.

    ``state``: held and not held (thresholds), broken (its files are wrong), fault (stiffcal's own), lost (its process
    was ended each time). Numbers are null where it did not come so far. ``choices``: what the author of campaign.toml
    has left out or asks for.
    """

    campaign: str
    folder: str
    name: str
    state: Literal["held", "not held", "broken", "fault", "lost"]
    steps: dict[str, BatchStep]
    failed_at: str | None
    seconds: float
    memory_bytes: int | None
    n_states: int | None
    n_runs: int | None
    rms: RmsEntry | None
    noise: RmsEntry | None
    relative: RmsEntry | None
    stiffness: list[JointStiffness]
    checks: list[Threshold]
    failed: list[str]
    not_judged: list[str]
    warnings: list[str]
    choices: list[AuthorChoice]
    report: str | None
    origin: Origin | None
    error: FaultEntry | None
    others: list[FaultEntry]


class BatchCounts(TypedDict):
    """How many campaigns ended how."""

    campaigns: int
    held: int
    not_held: int
    broken: int
    unchanged: int


class BatchWorkers(TypedDict):
    """Who has worked: processes on this machine, or threads of a Dask cluster."""

    kind: Literal["processes", "dask"]
    count: int


class BatchAnswer(TypedDict):
    """Answer of ``batch``."""

    schema: Literal["stiffcal/batch/1"]
    warnings: list[str]
    passed: bool
    counts: BatchCounts
    seconds: float
    workers: BatchWorkers
    peak_memory_bytes: int | None
    campaigns: list[BatchCampaign]
