"""What the commands answer with ``--json``, typed; SI units, null for what is not known.

Documents may hold more than stands here: what does stand here is what other programs may rely on.
"""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.diagnosis.suspects.result import RunsNotChecked, Suspect
from stiffcal.experiments.results import HeldoutSection
from stiffcal.workflow.document_types import FaultEntry, Number, Origin, RmsEntry, Threshold


class Part(TypedDict):
    """The error in a part of the data."""

    label: str
    low: Number
    high: Number
    n: int
    rms: RmsEntry
    max: RmsEntry
    zero_model: NotRequired[RmsEntry]


class Worst(TypedDict):
    """A state with a large residual."""

    run: str
    row: int
    residual_m: float


class Validate(TypedDict):
    """Answer of ``validate``."""

    schema: Literal["stiffcal/validate/1"]
    warnings: list[str]
    scheme: str
    rms: RmsEntry
    max: RmsEntry
    noise: RmsEntry | None
    relative: RmsEntry
    zero_model: RmsEntry
    by_run: list[Part]
    by_direction: list[Part]
    by_load: list[Part]
    by_branch: list[Part]
    by_joint_angle: list[Part]
    by_body: NotRequired[list[Part]]
    by_joint: NotRequired[list[Part]]
    clamped: NotRequired[HeldoutSection]
    friction: NotRequired[HeldoutSection]
    worst: list[Worst]
    suspects: NotRequired[list[Suspect]]
    suspects_not_checked: NotRequired[RunsNotChecked]
    passed: bool
    failed: list[str]
    not_judged: list[str]
    checks: list[Threshold]
    origin: NotRequired[Origin]


class Error(TypedDict):
    """Answer of any command with exit code 2 or 3; ``others`` where there are more faults."""

    error: FaultEntry
    others: NotRequired[list[FaultEntry]]
