"""What an answer or a kind of experiment has to show, as plain values: sentences, tables, pictures.

Terminal, PDF, browser and notebook draw these without knowing what they are of. A number is written once, by `texts`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from stiffcal.presentation.words import Words

if TYPE_CHECKING:
    from stiffcal.presentation.pictures import Picture

Level: TypeAlias = Literal["note", "warning", "question", "pass", "warn", "fail"]
"""Of a sentence: a note, a warning, a question, which stands where somebody reads it now, or a verdict, which says how
what was asked stands."""


ORIGIN = "origin"
"""The code of a sentence on who has computed an answer: it stands before the verdict."""


@dataclass(frozen=True)
class Sentence:
    """A text that stands by itself."""

    words: Words
    code: str
    """What it is about, for programs: "definition", "not-identified" and so on."""
    level: Level = "note"
    starts_paragraph: bool = False
    """Whether a line is left free above it where lines follow each other, as in a terminal."""

    @property
    def is_verdict(self) -> bool:
        """Whether it says how what was asked stands."""
        return self.level in ("pass", "warn", "fail")


# ---- tables ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Column:
    """A table's column."""

    title: str
    unit: str = ""
    """"" where there is none."""
    numbers: bool = True
    """Numbers stand right, texts left."""
    is_wide: bool = False
    """Whether its texts wrap, and it takes the room that others leave on a printed page."""
    is_secondary: bool = False
    """Whether a terminal that is too narrow for all columns leaves it out."""


@dataclass(frozen=True)
class Table:
    """Rows of texts."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Words, ...], ...]
    """As many cells as there are columns."""
    caption: str = ""


@dataclass(frozen=True)
class Bar:
    """An amount of `Bars`."""

    name: str
    size: float | None
    """Its length; None where nothing is drawn."""
    text: str
    """The number as it is written."""
    is_on_scale: bool = False
    """Whether the scale is made so that it has room."""


@dataclass(frozen=True)
class Bars:
    """Amounts as bars, linear from zero; the last is a floor, which is marked in every bar."""

    title: str
    """Of the names."""
    amount: str
    """What the bars are."""
    bars: tuple[Bar, ...]


# ---- the whole ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Subheading:
    """A heading within a page."""

    text: str
    is_title: bool = False
    """A title by itself, and not the beginning of what goes on below it: bold in a terminal too."""


@dataclass(frozen=True)
class Listing:
    """Sentences one below the other, each a point of a list."""

    sentences: tuple[Sentence, ...]


Block: TypeAlias = "Sentence | Table | Bars | Picture | Subheading | Listing"


@dataclass(frozen=True, slots=True)
class NextStep:
    """What is done after an answer."""

    command: str
    """A line to copy."""
    once: str = ""
    """What a person has to do or to have first, in words; "" where the command runs as it is."""

    @property
    def text(self) -> str:
        """As it is written: only a command that runs now stands after "next"."""
        return f"once {self.once}: {self.command}" if self.once else f"next: {self.command}"


@dataclass(frozen=True)
class Overview:
    """What ``identify`` shows of a kind in the terminal."""

    blocks: tuple[Sentence | Table, ...]
    details: tuple[Sentence | Table, ...] = ()
    """Printed with ``--details`` only."""
    parameters: frozenset[str] = frozenset()
    """Names of parameters that stand here: the table of all parameters leaves them out."""


@dataclass(frozen=True)
class UnusedReadings:
    """Readings of a run that were not used."""

    run: str
    numbers: tuple[int, ...]
    """From 1, in the run."""
    why: str


@dataclass(frozen=True)
class Page:
    """What every medium shows of an answer, and the report of a kind of experiment."""

    title: str
    blocks: tuple[Block, ...]
    """Empty where nothing can be shown."""
    subject: str = ""
    """Of a kind: what was done, for the line under the report's title: "clamped robot"."""
    subject_of_model: str = ""
    """Where the campaign holds this kind alone: what was fitted, for the report's title and its first sentence; "":
    the robot's model."""
    fitted: str = ""
    """Likewise, with the number of what was fitted."""
    why_empty: str = ""
    """Where `blocks` is empty."""
    parameters: frozenset[str] = frozenset()
    """Names of parameters that stand here: other pages leave them out."""
    unused: tuple[UnusedReadings, ...] = ()
    next_step: NextStep | None = None
    """What an answer leads to; None where nothing follows, or where that is not asked."""


@dataclass(frozen=True)
class Plot:
    """One picture that ``plot`` draws of a kind."""

    picture: Picture
    drawn: str
    """What is in it, in words."""
