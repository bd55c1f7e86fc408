"""A page, block by block."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.presentation.values import Block, Column, Level, Listing, Page, Sentence, Subheading, Table

if TYPE_CHECKING:
    from stiffcal.presentation.pictures import Picture


def number(title: str, is_secondary: bool = False) -> Column:
    """Return a column of numbers; a secondary one is left out where a terminal has no room for it."""
    return Column(title, is_secondary=is_secondary)


def roomy(column: Column) -> Column:
    """Return a column that is left out where a terminal has no room for it."""
    return replace(column, is_secondary=True)


def wide(title: str) -> Column:
    """Return a column of texts that wrap, and take the room that others leave on a printed page."""
    return Column(title, numbers=False, is_wide=True)


class PageBuilder:
    """Takes sentences, tables and pictures in the order in which they are read.

    Parameters
    ----------
    title : of the page.
    """

    def __init__(self, title: str) -> None:
        self.title = title
        self._blocks: list[Block] = []

    def say(self, text: str, code: str, level: Level = "note", starts_paragraph: bool = False) -> None:
        """Add a sentence; `code` is what it is about, for programs."""
        self._blocks.append(Sentence((text,), code, level, starts_paragraph))

    def list(self, texts: Iterable[str], code: str) -> None:
        """Add sentences as points of a list, unless there is none; `code` is what they are about."""
        points = tuple(Sentence((text,), code) for text in texts)
        if points:
            self._blocks.append(Listing(points))

    def head(self, text: str, is_title: bool = False) -> None:
        """Add a heading to what follows; a title stands by itself."""
        self._blocks.append(Subheading(text, is_title))

    def table(self, columns: Sequence[str | Column], rows: Iterable[Sequence[str]], caption: str = "") -> None:
        """Add a table, unless it has no row.

        Parameters
        ----------
        columns : their titles, of texts, or `number(title)`, `wide(title)`; units in the titles.
        rows : texts. caption : of the table.
        """
        titled = tuple(Column(one, numbers=False) if isinstance(one, str) else one for one in columns)
        cells = tuple(tuple((text,) for text in row) for row in rows)
        if cells:
            self._blocks.append(Table(titled, cells, caption))

    def draw(self, picture: Picture) -> None:
        """Add a picture."""
        self._blocks.append(picture)

    def add(self, blocks: Iterable[Block]) -> None:
        """Add blocks as they are."""
        self._blocks.extend(blocks)

    def page(self) -> Page:
        """Return the page."""
        return Page(self.title, tuple(self._blocks))
