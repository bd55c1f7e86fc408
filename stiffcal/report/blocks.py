"""What pages are built of: blocks of text, tables and pictures that the typst template sets one under the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Paragraph:
    """Running text; `tone` "plain", "key" (framed: the answer of a section), "quiet" (small)."""

    text: str
    tone: str = "plain"


@dataclass(frozen=True)
class VerdictBlock:
    """The answer of the whole report, in the colour of its level: of the first page alone."""

    level: Literal["ok", "attention", "not usable"]
    """Printed too: a page may be printed in grey."""
    text: str
    """In a sentence."""


@dataclass(frozen=True)
class NumbersBlock:
    """Few numbers in large type, next to each other."""

    numbers: tuple[tuple[str, str], ...]
    """What each is, and the number with its unit."""


@dataclass(frozen=True)
class Items:
    """A list of points."""

    texts: tuple[str, ...]


@dataclass(frozen=True)
class SubheadingBlock:
    """A heading inside a section; it gets a bookmark of its own."""

    text: str


@dataclass(frozen=True)
class Facts:
    """Names and values in two columns."""

    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class TableColumn:
    """A table's column."""

    title: str
    """What it holds."""
    unit: str = ""
    """Printed under the title in brackets; "" where there is none."""
    align: str = "right"
    """"left" or "right"."""
    width: float = 0.0
    """Share of the free width; 0 takes what the cells need."""
    mono: bool = False
    """Set in a typewriter face."""


@dataclass(frozen=True)
class TableBlock:
    """A table that breaks over pages and repeats its header there."""

    columns: tuple[TableColumn, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str
    doubtful: tuple[tuple[int, int], ...] = ()
    """Cells, row and column from 0, whose numbers are known to be wrong: they are grey."""

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"every row of the table {self.caption!r} needs {len(self.columns)} cells")


@dataclass(frozen=True)
class PictureBlock:
    """A picture, drawn only when the report is made."""

    draw: Callable[[], Figure]
    """Makes the figure."""
    caption: str
    """What is observed, with numbers."""


Block: TypeAlias = Paragraph | VerdictBlock | NumbersBlock | Items | SubheadingBlock | Facts | TableBlock | PictureBlock


@dataclass(frozen=True)
class ReportSection:
    """A section of the report: its heading and what stands under it."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class LeftOut:
    """A section that has nothing to show, and why."""

    title: str
    reason: str
