"""What an answer or a kind of experiment has to show, as plain values: sentences, tables, pictures.

Terminal, PDF, browser and notebook draw these without knowing what they are of. A number is written once, by `texts`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stiffcal.arrays import Floats, Integers
from stiffcal.estimate import Estimate

# ---- words ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Digits:
    """A number in a text; what is not known is drawn as a dash."""

    value: float | None
    significant: int = 3


@dataclass(frozen=True)
class Names:
    """Names listed in a text."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Joints:
    """Joints listed in a text, from 1."""

    joints: tuple[int, ...]


Words: TypeAlias = tuple[str | Digits | Estimate | Names | Joints, ...]
"""A text, piece by piece; nothing stands between the pieces. An estimate with a quantity is written with its unit; in a
table it has that of the column."""


Level: TypeAlias = Literal["note", "warning", "pass", "warn", "fail"]
"""Of a sentence: a note, a warning, or a verdict, which says how what was asked stands."""


@dataclass(frozen=True)
class Sentence:
    """A text that stands by itself."""

    words: Words
    code: str
    """What it is about, for programs: "definition", "not-identified" and so on."""
    level: Level = "note"

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


@dataclass(frozen=True)
class Table:
    """Rows of texts."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Words, ...], ...]
    """As many cells as there are columns."""
    caption: str = ""


# ---- pictures -------------------------------------------------------------------------------------------------------

Colour: TypeAlias = int | Literal["model", "quiet"]
"""A colour of the palette by its number, the model's, or that of what is not important."""


@dataclass(frozen=True)
class Marks:
    """Points of a picture."""

    x: Floats
    """(n,)"""
    y: Floats
    """(n,)"""
    marker: str
    """"^", "v", "o", "x", or "0", "1", … for the n-th of the palette."""
    colour: Colour
    size: float = 3.0
    """Points of print."""
    edge: float = 0.7
    """Points of print."""
    is_hollow: bool = True
    opacity: float = 1.0
    label: str = ""
    """In the legend; "" where it stands in none."""
    layer: float = 3.0
    """Higher ones cover lower ones."""
    spread: Floats | None = None
    """(n,) half the height of a bar through the point; None: no bar."""
    note: str = ""
    """Written above the last point, upright."""
    run: str = ""
    """The run that all points are of; "" of several."""
    sweep: Literal["", "up", "down", "both"] = ""
    """Of a clamped run's points whose y is the torque on the moved joint: the half sweeps that they are of, by the
    direction of the angle; "" where they stand for the whole run."""
    rows: Integers | None = None
    """(n,) rows of the kind's table of fitted readings; None where a point is not one of them."""


@dataclass(frozen=True)
class Line:
    """A curve of a picture."""

    x: Floats
    """(n,)"""
    y: Floats
    """(n,)"""
    width: float = 1.1
    """Points of print."""
    is_dashed: bool = False
    colour: Colour = "model"
    label: str = ""
    layer: float = 4.0


@dataclass(frozen=True)
class Band:
    """What lies between two curves of a picture."""

    x: Floats
    """(n,)"""
    low: Floats
    """(n,)"""
    high: Floats
    """(n,)"""
    label: str = ""
    layer: float = 1.0


@dataclass(frozen=True)
class Span:
    """A stretch of the x axis over the whole height."""

    low: float
    high: float
    label: str = ""
    layer: float = 0.0


Series: TypeAlias = Marks | Line | Band | Span


@dataclass(frozen=True)
class Panel:
    """A pair of axes with what is drawn in it."""

    title: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]
    x_limits: tuple[float, float] | None = None
    """None: what the series need."""
    y_limits: tuple[float, float] | None = None
    """None: what the series need."""
    head_room: float | None = None
    """The y axis begins at zero or below and has this share left above the series; None: it does not."""
    x_names: tuple[str, ...] = ()
    """Written at 0, 1, … of the x axis instead of numbers."""
    y_names: tuple[str, ...] = ()
    """Likewise of the y axis."""
    x_ticks: int | None = None
    """So many numbers at the x axis at most."""
    has_zero_lines: bool = False
    has_own_legend: bool = False
    """Its labels stand in the panel, not above all panels."""
    empty: str = ""
    """Where there is nothing to draw: why."""
    joint: str = ""
    """The joint that it shows alone; pages in a browser show one joint at a time."""


@dataclass(frozen=True)
class Picture:
    """Panels side by side, row by row."""

    panels: tuple[Panel, ...]
    columns: int
    height: float
    """mm, of the whole."""
    caption: Words = ()
    widths: tuple[float, ...] = ()
    """Of the columns, relative to each other; empty: equal."""


# ---- the whole ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Subheading:
    """A heading within a page."""

    text: str


@dataclass(frozen=True)
class Listing:
    """Sentences one below the other, each a point of a list."""

    sentences: tuple[Sentence, ...]


Block: TypeAlias = Sentence | Table | Picture | Subheading | Listing


@dataclass(frozen=True)
class Overview:
    """What ``identify`` shows of a kind in the terminal."""

    blocks: tuple[Sentence | Table, ...]
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


@dataclass(frozen=True)
class Plot:
    """One picture that ``plot`` draws of a kind."""

    picture: Picture
    drawn: str
    """What is in it, in words."""
