"""What a command answers where the input is wrong."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.documents import OrAbsent
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultEntry:
    """What is wrong with the input."""

    code: FaultCode
    """Which kind of fault it is; stable."""
    file: str
    """The file, or "command line"."""
    place: str
    """Where in it."""
    reason: str
    """What is wrong."""
    mend: str
    """What to do about it."""

    @classmethod
    def of(cls, fault: Fault) -> FaultEntry:
        """Return a fault as results hold it."""
        return cls(code=fault.code, file=fault.file, place=fault.place, reason=fault.reason, mend=fault.mend)

    def __str__(self) -> str:
        """Return the one line that the command line prints."""
        return str(Fault(self.code, self.file, self.place, self.reason, self.mend))


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorResult:
    """Answer of any command with exit code 2 or 3."""

    error: FaultEntry
    """The most informative fault."""
    others: OrAbsent[list[FaultEntry]] = None
    """Further faults, where there are more."""
