"""What reading the logs of one run gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stiffcal.ingest.quality.data_quality import ReadLog
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.ingested_runs import UnusedData
from stiffcal.reduction.states.raw_states import RawStates


@dataclass(frozen=True)
class ReadRun:
    """What reading the logs of a run gave."""

    id: str
    """Its name."""
    logs: tuple[ReadLog, ...]
    """What was seen of each."""
    states: RawStates | None = None
    """Its load states, in the instruments' own axes; None of kinds of experiment that take the logs as blocks."""
    clocks: Mapping[str, SourceClockOffset] = field(default_factory=dict)
    """Source to offset."""
    dropped: tuple[UnusedData, ...] = ()
    """Pieces of its logs that no state uses."""
    warnings: tuple[str, ...] = ()
    """What the user ought to know."""
    passes: int = 0
    """Of a load that was swept: how often it went from one turning point to the next; 0 where it was held."""
    blocks: Mapping[str, Blocks] = field(default_factory=dict)
    """Source to block averages, of kinds of experiment that reduce them together."""
