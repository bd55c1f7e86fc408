"""What `ingest` answers of a run: its clocks, its states or readings, and what of it is not used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from stiffcal.documents import NOT_PROMISED, OrAbsent
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.holds.unused import UnusedStretch, by_cause, cause_text


@dataclass(frozen=True, slots=True, kw_only=True)
class UnusedData:
    """A load state of a run, or pieces of its logs, that are not used."""

    state: OrAbsent[int] = None
    """The state's data row of the table or number of the hold, from 1; None of pieces."""
    why: str
    """In words."""
    code: str
    """The same as a `UnusedCode`, or a `SetAsideCode` of a state or reading."""
    pieces: OrAbsent[int] = None
    """How many pieces were not used for this reason; None of a state."""
    seconds: OrAbsent[float] = None
    """How long they are together, s."""
    first_s: OrAbsent[list[float]] = None
    """Start and end of the first one, s on the first source's clock."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IngestedRun:
    """What was made of a run."""

    id: str
    """Its name."""
    clock_ahead_s: dict[str, SourceClockOffset]
    """Of each source, against the first."""
    n_states: int
    """How many load states are used."""
    n_readings: Annotated[OrAbsent[int], NOT_PROMISED] = None
    """Of a run that is not of load states alone: how many readings are used."""
    dropped: list[UnusedData]
    """What is not used."""
    passes: OrAbsent[int] = None
    """Where the load was swept: how often, up and down separately."""


def sum_up_dropped(dropped: Sequence[UnusedStretch]) -> list[UnusedData]:
    """Sum up what was not used of a run's logs, by cause."""
    return [
        UnusedData(
            why=cause_text(pieces),
            code=pieces[0].code.value,
            pieces=len(pieces),
            seconds=float(sum(piece.end - piece.start for piece in pieces)),
            first_s=[float(pieces[0].start), float(pieces[0].end)],
        )
        for pieces in by_cause(dropped)
    ]
