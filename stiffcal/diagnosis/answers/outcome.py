"""What the step after a diagnosis depends on: read from its document without all the rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stiffcal.model.summary import EffectAt


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnosisOutcome:
    """A part of `DiagnoseResult`.

    A class of its own, as the whole builds 45 more and their readers: a fifth of the time of a command that only reads
    the store.
    """

    missing: list[EffectAt]
    """Effects to add, in order."""
    pattern: Any = None
    """Not None where something is left that an effect of one's own would test."""
    fit_id: str
    """The fit that was diagnosed."""
