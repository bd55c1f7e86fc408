"""Lines of campaign.toml and robot.toml that `init --from` and `check` propose, and the names that they use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stiffcal.escapes import toml_text

GUESS = "# ?"
"""Begins the comment of a line that was guessed."""


TOOL = "tool"


FORCE_SENSOR = "ft_sensor"


TRACKER = "tracker"
LOAD_POINT, TARGET = "load_point", "target"


PAYLOAD = "payload"


@dataclass(frozen=True)
class Question:
    """A value that no log states."""

    table: str
    """The table of the line, as ``frames.tool``."""
    key: str
    """Of the line."""
    text: str
    """What the value is, in words."""
    numbers: tuple[str, ...] = ("x", "y", "z")
    """Of which numbers it is made."""
    form: str = "[{}]"
    """How they are written, by `str.format`."""

    def line(self, numbers: Sequence[float | str]) -> str:
        """Return the line with numbers in it.

        Examples
        --------
        >>> Question("frames.tool", "xyz_m", "where it is").line([0.0, 0.0, 0.2])
        'xyz_m = [0.0, 0.0, 0.2]'
        """
        return f"{self.key} = {self.form.format(', '.join(map(str, numbers)))}"


@dataclass(frozen=True)
class ProposedLine:
    """A line of a proposed file; as text it ends with `GUESS` and the doubt, where it was guessed."""

    toml: str
    """What stands before the comment, "" of a comment alone."""
    doubt: str | None = None
    """What a person should check, "" where the value itself shows it; None where nothing was guessed."""
    frames: tuple[str, ...] = ()
    """The frames that it names."""
    question: Question | None = None
    """What a person is asked where nothing can be guessed: the line's value is then still to be written."""

    def __str__(self) -> str:
        comment = None if self.doubt is None else f"{GUESS} {self.doubt}".rstrip()
        return "  ".join(piece for piece in (self.toml, comment) if piece)


@dataclass(frozen=True)
class FrameNames:
    """The names of the frames that proposed lines use."""

    body: str = TOOL
    """Where the displacement is measured."""
    point: str = TOOL
    """Where a force without moments acts."""
    axes: str = "base"
    """In whose axes a force without moments is measured, unless its columns' names say it."""


DEFAULT_NAMES = FrameNames()


def as_text(lines: Sequence[ProposedLine]) -> str:
    """Return the lines as the text of a file."""
    return "".join(f"{line}\n" for line in lines)


def frame_table(frame: str, parent: str) -> list[ProposedLine]:
    """Return the head of a frame's table."""
    return [ProposedLine(text) for text in ("", f"[frames.{frame}]", f"parent = {toml_text.value(parent)}")]


def question_line(frame: str, key: str, what: str) -> ProposedLine:
    """Return the line of three numbers of a frame that no log states; `what` they are, in words."""
    return ProposedLine(f"{key} = []", f"to be filled in: {what}", question=Question(f"frames.{frame}", key, what))
