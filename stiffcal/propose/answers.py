"""What no log states: asked for at a terminal, or left as a list of lines to write."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.further_logs import FurtherLog
from stiffcal.propose.lines import ProposedLine, Question
from stiffcal.propose.templates import bundled_robots

Ask = Callable[[Question], str]


def answered(lines: Sequence[ProposedLine], ask: Ask | None) -> list[ProposedLine]:
    """Return the lines with the answers of a person, where one is asked and gives some."""
    known = []
    for line in lines:
        text = ask(line.question) if ask is not None and line.question is not None else ""
        if text and line.question is not None:
            line = ProposedLine(line.question.line(numbers_of(text, len(line.question.numbers))))
        known.append(line)
    return known


def numbers_of(text: str, count: int) -> tuple[float, ...]:
    """Read ``X,Y,Z``, or one number.

    Raises
    ------
    InputError : these are not so many numbers.

    Examples
    --------
    >>> numbers_of("0, 0 0.2", 3), numbers_of("50", 1)
    ((0.0, 0.0, 0.2), (50.0,))
    """
    try:
        numbers = tuple(float(word) for word in text.replace(",", " ").replace(";", " ").split())
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        mend = "give three numbers: X, Y, Z" if count == 3 else "give one number"
        raise InputError.at(FaultCode.VALUE_INVALID, "answer", "", f"found {text!r}", mend)
    return numbers


def to_write_by_hand(lines: Sequence[ProposedLine], missing: Sequence[FurtherLog], has_robot: bool) -> tuple[str, ...]:
    """Return what a person has to write: each line with its file and table."""
    written = [
        f"{MANIFEST_FILE} [{line.question.table}] {line.question.line(line.question.numbers)}  # {line.question.text}"
        for line in lines
        if line.question is not None
    ]
    written += [
        f"{MANIFEST_FILE} [sources.{signal.source}] {signal.signal}  # {signal.what}: no log here holds them"
        for signal in missing
    ]
    return tuple(written if has_robot else [*written, _ROWS])


_ROWS = (
    "robot.toml: the rows of its Denavit-Hartenberg table, and the flange; or begin again with --urdf FILE, "
    f"--robot FILE (the robot.toml of another campaign) or --robot NAME ({', '.join(bundled_robots())})"
)
