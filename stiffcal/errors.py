"""The errors a user can meet.

Every mistake in a user's input is a `Fault` of an `InputError`: one line that names the file, the place in it, the
reason and the mend. The command line prints it and ends with exit code 2; nothing has been written by then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from stiffcal.escapes import terminal
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import mask

Progress: TypeAlias = Callable[[str, float | None], None]
"""`progress(text, fraction)`: what is being done, and how much of it (0 to 1, None where unknown)."""


def no_progress(text: str, fraction: float | None = None) -> None:
    """Ignore progress; the default of every long function.

    Examples
    --------
    >>> no_progress("reading", 0.5)
    """


def part_of(progress: Progress, start: float, end: float) -> Progress:
    """Return the progress of a part of something, from one share of the whole to another.

    Examples
    --------
    >>> part_of(lambda text, share: print(text, share), 0.5, 1.0)("reading", 0.5)
    reading 0.75
    """

    def report(text: str, fraction: float | None = None) -> None:
        progress(text, None if fraction is None else start + (end - start) * fraction)

    return report


MOST_SHOWN = 600  # characters of one part of a fault: the longest list of keys, not a file's whole content


def one_line(text: str, most: int = MOST_SHOWN) -> str:
    r"""Return a text on one line: what a terminal would obey is written out, what is too long is cut in its middle.

    Examples
    --------
    >>> print(one_line("two\nlines"), one_line("x" * 50, 9))
    two\nlines xxxx…xxxx
    """
    text = terminal.escaped(text)
    return text if len(text) <= most else f"{text[: most // 2]}…{text[-(most // 2) :]}"


@dataclass(frozen=True)
class Fault:
    """One fault in a user's input."""

    code: FaultCode
    """The family that the fault belongs to, which stays whatever the words are."""
    file: str
    """The file as the user named it (relative to the campaign folder where it lies inside), or "" where none."""
    place: str
    """Line, column, key or run inside the file, e.g. ``line 12, column Fx`` or ``[sources.ft] units.force``."""
    reason: str
    """What is wrong, with the value that was found."""
    mend: str
    """What to do about it."""
    names: tuple[str, ...] = ()
    """What of the manifest the reason is about (frames, sources, runs, columns), for who sorts faults."""
    changes: tuple[InputChange, ...] = ()
    """With which change of the input the data agree, the one that is named first; empty where none is known."""
    rows: tuple[int, ...] = ()
    """Numbers of the rows of ``file`` that it is about, where these are some of them."""

    def __post_init__(self) -> None:
        for name in ("file", "place", "reason", "mend"):
            # Masked before it is cut: half a secret would pass. Of a very long text only its ends may be shown.
            text = getattr(self, name)
            text = text if len(text) <= 20 * MOST_SHOWN else text[: 10 * MOST_SHOWN] + text[-10 * MOST_SHOWN :]
            object.__setattr__(self, name, one_line(mask(text)))

    def __str__(self) -> str:
        where = ": ".join(part_text for part_text in (self.file, self.place) if part_text)
        text = f"{self.reason}; {self.mend} [{self.code}]"
        return f"{where}: {text}" if where else text

    def as_document(self) -> dict[str, str]:
        """Return the fault as the `error` object of the JSON interface."""
        return {
            "code": self.code.value,
            "file": self.file,
            "place": self.place,
            "reason": self.reason,
            "mend": self.mend,
        }


class InputError(Exception):
    """The user's input is wrong; exit code 2. Carries one or more faults, the most informative first."""

    def __init__(self, *faults: Fault) -> None:
        if not faults:
            raise ValueError("an InputError needs at least one fault")
        super().__init__("\n".join(str(fault) for fault in faults))
        self.faults: tuple[Fault, ...] = faults

    @property
    def code(self) -> FaultCode:
        """The family of the first fault."""
        return self.faults[0].code

    @property
    def file(self) -> str:
        """The file of the first fault."""
        return self.faults[0].file

    @property
    def place(self) -> str:
        """The place of the first fault in its file."""
        return self.faults[0].place

    @property
    def reason(self) -> str:
        """What is wrong, of the first fault."""
        return self.faults[0].reason

    @property
    def mend(self) -> str:
        """What to do about the first fault."""
        return self.faults[0].mend

    @classmethod
    def at(cls, code: FaultCode, file: str, place: str, reason: str, mend: str) -> InputError:
        """Make an error of a single fault.

        Examples
        --------
        >>> error = InputError.at(FaultCode.FILE_MISSING, "campaign.toml", "robot", "no such file", "correct the name")
        >>> str(error)
        'campaign.toml: robot: no such file; correct the name [file-missing]'
        """
        return cls(Fault(code, file, place, reason, mend))


def raise_faults(faults: Sequence[Fault]) -> None:
    """Raise an `InputError` with all `faults`, or return where there are none."""
    if faults:
        raise InputError(*faults)
