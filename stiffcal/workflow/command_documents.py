"""What the commands around the fit answer, typed: ``init``, ``check``, ``add``, ``plot``, ``report``, ``run``."""

from __future__ import annotations

from typing import Any, Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Number
from stiffcal.workflow.link_documents import RodView


class ColumnSeen(TypedDict):
    """A column of a log: the unit it is written in, its range in SI units, whether it moved."""

    signal: str
    column: str
    unit: str
    low_si: Number
    high_si: Number
    moved: bool


class SourceSeen(TypedDict):
    """A log as it was understood; tables of states have no rate, span and gap."""

    source: str
    file: str
    rows: int
    rate_hz: NotRequired[Number]
    span_s: NotRequired[Number]
    longest_gap_s: NotRequired[Number]
    columns: list[ColumnSeen]


class RunSeen(TypedDict):
    """A run: how many load states, or readings of another experiment; which were set aside."""

    id: str
    experiment: str
    n_states: int
    n_readings: NotRequired[int]
    set_aside: list[Any]
    largest_force_N: Number


class JointSeen(TypedDict):
    """How well a joint can be identified from what has been measured so far."""

    joint: str
    largest_torque_Nm: Number
    expected_relative_std: Number
    says: str


class ProposedSource(TypedDict):
    """Logs in ``raw`` that the manifest does not name: whose export they seem to be ("" not known), lines to copy."""

    files: list[str]
    device: str
    lines: list[str]


class Check(TypedDict):
    """Answer of ``check``; ``missing`` says what is still to be measured or written. ``joints``: not with --quick."""

    schema: Literal["stiffcal/check/1"]
    warnings: list[str]
    campaign: str
    sources: list[SourceSeen]
    runs: list[RunSeen]
    kinematics: dict[str, Any] | None
    n_states: int
    ready: bool
    missing: list[str]
    joints: NotRequired[list[JointSeen]]
    rods: NotRequired[list[RodView]]
    proposals: NotRequired[list[ProposedSource]]


class Run(TypedDict):
    """Answer of ``run``: the documents of the steps, the PDF, whether the thresholds hold."""

    schema: Literal["stiffcal/run/1"]
    warnings: list[str]
    check: dict[str, Any]
    identify: dict[str, Any]
    validate: dict[str, Any]
    diagnose: dict[str, Any]
    report: str
    passed: bool
