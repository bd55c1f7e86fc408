"""What the commands around the fit answer, typed: ``init``, ``check``, ``add``, ``plot``, ``report``, ``run``."""

from __future__ import annotations

from typing import Any, Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Model, Number, Origin
from stiffcal.workflow.link_documents import RodView


class Init(TypedDict):
    """Answer of ``init``: what was written, and the lines that were guessed."""

    schema: Literal["stiffcal/init/1"]
    warnings: list[str]
    files: list[str]
    guessed: list[str]


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


class Edit(TypedDict):
    """Answer of ``add`` and ``remove``: what changed in model.toml, and the model now."""

    schema: Literal["stiffcal/edit/1"]
    warnings: list[str]
    changes: list[str]
    model: Model


class EffectParameter(TypedDict):
    """A parameter of an effect."""

    symbol: str
    unit: str
    meaning: str
    bounds: list[Number]
    typical: Number
    source: str


class EffectTold(TypedDict):
    """An effect of the catalogue."""

    name: str
    place: str
    summary: str
    physics: str
    parameters: list[EffectParameter]
    needs: list[str]
    fingerprint: str
    looks_like: list[str]


class Effects(TypedDict):
    """Answer of ``effects``; for one effect that shows with its picture in letters, line by line."""

    schema: Literal["stiffcal/effects/1"]
    warnings: list[str]
    effects: list[EffectTold]
    sketch: NotRequired[list[str]]


class Simulate(TypedDict):
    """Answer of ``simulate``: the campaign folder that was written."""

    schema: Literal["stiffcal/simulate-result/1"]
    warnings: list[str]
    folder: str
    files: list[str]
    seed: int
    runs: list[str]
    states: int


class Plot(TypedDict):
    """Answer of ``plot``: the picture's file and what it shows."""

    schema: Literal["stiffcal/plot/1"]
    warnings: list[str]
    file: str
    drawn: str


class Report(TypedDict):
    """Answer of ``report``: the PDF."""

    schema: Literal["stiffcal/report/1"]
    warnings: list[str]
    file: str
    origin: NotRequired[Origin]


class StatesExport(TypedDict):
    """Answer of ``export``: the file and what it holds."""

    schema: Literal["stiffcal/export/1"]
    warnings: list[str]
    file: str
    holds: str


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
