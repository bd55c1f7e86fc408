"""What ``run`` and ``demo`` answer: the answers of all steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.documents import HAS_OWN_SCHEMA, NOT_IN_DOCUMENT, NOT_PROMISED, CommandResult, KeyIf
from stiffcal.ingest.checks.results import CheckResult
from stiffcal.results.history_results import HistoryResult
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult


@dataclass(frozen=True, slots=True, kw_only=True)
class RunResult(CommandResult):
    """Answer of ``run``."""

    schema: Literal["stiffcal/run/1"] = "stiffcal/run/1"
    check: Annotated[CheckResult, HAS_OWN_SCHEMA]
    """What was understood of the campaign."""
    identify: Annotated[IdentifyResult, HAS_OWN_SCHEMA]
    """The fit."""
    validate: Annotated[ValidateResult, HAS_OWN_SCHEMA]
    """Its validation."""
    diagnose: Annotated[DiagnoseResult, HAS_OWN_SCHEMA]
    """Its diagnosis."""
    report: str
    """The PDF."""
    view: str
    """The page for a browser."""
    passed: bool
    """Whether the thresholds hold."""
    folder: Annotated[str | None, KeyIf("", null=False), NOT_PROMISED] = None
    """Of ``demo``: where the example was copied to."""
    history: Annotated[HistoryResult | None, NOT_IN_DOCUMENT] = None
    """Of ``demo``: all its fits."""
