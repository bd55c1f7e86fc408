"""What the commands around the fit answer: files that were written, the model, the catalogue of effects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.documents import NOT_IN_DOCUMENT, NOT_PROMISED, CommandResult, Number, OrAbsent, Origin
from stiffcal.model.summary import ModelSummary
from stiffcal.propose.explained_column import ExplainedColumn


@dataclass(frozen=True, slots=True, kw_only=True)
class InitResult(CommandResult):
    """Answer of ``init``."""

    schema: Literal["stiffcal/init/1"] = "stiffcal/init/1"
    files: list[str]
    """What was written."""
    guessed: list[str]
    """The lines of campaign.toml to look at."""
    columns: OrAbsent[list[ExplainedColumn]] = None
    """Of logs and tables: every column, what it is taken for and why, or why it is not taken."""
    to_write: OrAbsent[list[str]] = None
    """Of logs and tables: the lines that are left to be written, as none states their values."""
    runs: OrAbsent[list[str]] = None
    """Of a folder of logs: the runs that its files make."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EditResult(CommandResult):
    """Answer of ``add`` and ``remove``."""

    schema: Literal["stiffcal/edit/1"] = "stiffcal/edit/1"
    changes: list[str]
    """What changed in model.toml, in words."""
    model: ModelSummary
    """What it holds now."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectParameter:
    """A parameter of an effect."""

    symbol: str
    """As in parameter names."""
    unit: str
    """SI."""
    meaning: str
    """In words."""
    bounds: list[Number]
    """Lowest and highest value; null: none."""
    typical: Number
    """A typical size."""
    source: str
    """Where that size is from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectDescription:
    """An effect of the catalogue."""

    name: str
    """As in model.toml."""
    place: str
    """What it sits at: joints, links, pairs or set-up."""
    kind: Annotated[str, NOT_PROMISED]
    """How it enters the model."""
    summary: str
    """In a phrase."""
    physics: str
    """What it is, its law, what it assumes."""
    parameters: list[EffectParameter]
    """What a fit finds of it."""
    needs: list[str]
    """Signals without which no data show it."""
    includes: Annotated[list[str], NOT_PROMISED]
    """Effects that it holds already."""
    excludes: Annotated[list[str], NOT_PROMISED]
    """Effects that may not stand at the same place."""
    fingerprint: str
    """How it shows in data."""
    looks_like: list[str]
    """Effects that are mistaken for it."""
    check: Annotated[str, NOT_PROMISED]
    """How to check it on the machine."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectsResult(CommandResult):
    """Answer of ``effects``."""

    schema: Literal["stiffcal/effects/1"] = "stiffcal/effects/1"
    effects: list[EffectDescription]
    """All of the catalogue, or the one that was asked for."""
    sketch: OrAbsent[list[str]] = None
    """For one effect that shows: its picture in letters, line by line."""
    picture: Annotated[OrAbsent[str], NOT_PROMISED] = None
    """The picture that was written."""
    drawn: Annotated[OrAbsent[str], NOT_PROMISED] = None
    """What it shows, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NewEffectResult(CommandResult):
    """Answer of ``effects new``."""

    schema: Literal["stiffcal/new-effect/1"] = "stiffcal/new-effect/1"
    effect: str
    """Its name."""
    file: str
    """The plugin that was written, in the campaign folder, and that campaign.toml now lists."""
    tests: str
    """What it tests, in words."""
    sha256: str
    """Of all plugins of the campaign: what `stiffcal trust` allows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulateResult(CommandResult):
    """Answer of ``simulate``."""

    schema: Literal["stiffcal/simulate-result/1"] = "stiffcal/simulate-result/1"
    folder: str
    """The campaign folder that was written."""
    files: list[str]
    """What is in it."""
    seed: int
    """Of all that was drawn by chance."""
    runs: list[str]
    """Names of the runs."""
    states: int
    """How many load states they reach."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlotResult(CommandResult):
    """Answer of ``plot``."""

    schema: Literal["stiffcal/plot/1"] = "stiffcal/plot/1"
    file: str
    """The picture."""
    drawn: str
    """What it shows, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportResult(CommandResult):
    """Answer of ``report``."""

    schema: Literal["stiffcal/report/1"] = "stiffcal/report/1"
    file: str
    """The PDF."""
    origin: OrAbsent[Origin] = None
    """From whom the results in it come."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewResult(CommandResult):
    """Answer of ``view``."""

    schema: Literal["stiffcal/view/1"] = "stiffcal/view/1"
    file: str
    """The page."""
    n_states: int
    """Load states of the campaign."""
    n_shown: int
    """Load states that are drawn; errors and shares are of all."""
    origin: OrAbsent[Origin] = None
    """From whom the results in it come."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveResult(CommandResult):
    """Answer of ``view --live``, when the page is served."""

    schema: Literal["stiffcal/live/1"] = "stiffcal/live/1"
    address: str
    """What to open in a browser on this machine; it holds a secret."""
    follows_logs: Annotated[bool, NOT_IN_DOCUMENT] = False
    """Whether the page follows logs that are being written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportResult(CommandResult):
    """Answer of ``export``."""

    schema: Literal["stiffcal/export/1"] = "stiffcal/export/1"
    file: str
    """What was written."""
    holds: str
    """What is in it, in words."""
