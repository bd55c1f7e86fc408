"""What `ingest` answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.documents import NOT_PROMISED, CommandResult, OrAbsent, Origin
from stiffcal.reduction.registration.frames import RegistrationSummary
from stiffcal.reduction.states.ingested_runs import IngestedRun


@dataclass(frozen=True, slots=True, kw_only=True)
class IngestResult(CommandResult):
    """Answer of ``ingest``."""

    schema: Literal["stiffcal/ingest/1"] = "stiffcal/ingest/1"
    n_states: Annotated[int, NOT_PROMISED]
    """How many load states are used."""
    n_set_aside: Annotated[int, NOT_PROMISED]
    """How many are not."""
    runs: list[IngestedRun]
    """What was made of each run."""
    rods_grew_m: OrAbsent[float] = None
    """m, the most that rods' growth with the temperature made within a run."""
    registration: Annotated[OrAbsent[RegistrationSummary], NOT_PROMISED] = None
    """Frames that were estimated."""
    unchanged: bool
    """Whether nothing had to be done."""
    changed: Annotated[str, NOT_PROMISED]
    """Which sources and settings made it necessary, in words; "" the first time."""
    origin: OrAbsent[Origin] = None
    """From whom the load states come."""
