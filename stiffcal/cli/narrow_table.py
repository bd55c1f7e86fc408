"""A table that splits no word on a narrow terminal: columns wrap between words; too many of them stack row by row.

In a module of its own: it needs rich when it is defined, which the list of commands and their help do not load.
"""

from __future__ import annotations

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

from stiffcal.cli.console import wrapped


class NarrowTable(Table):
    """A table whose columns are as wide as their longest word at least; numbers (aligned right) are never wrapped."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Draw the table within the width, as one block of lines per row where its words do not fit."""
        cells = [[str(cell) for cell in column._cells] for column in self.columns]
        least = [_least_width(column, texts) for column, texts in zip(self.columns, cells, strict=True)]
        widths = [
            max([smallest, cell_len(str(column.header)), *map(cell_len, texts)])
            for column, texts, smallest in zip(self.columns, cells, least, strict=True)
        ]
        room = options.max_width - 3 * max(len(widths) - 1, 0)
        if sum(least) > room:
            yield Text(
                wrapped("\n".join(self._stacked(cells, options.max_width)), options.max_width),
                overflow="ignore",
                no_wrap=True,
            )
            return
        while sum(widths) > room:
            slack = [width - smallest for width, smallest in zip(widths, least, strict=True)]
            widest = max((width for width, free in zip(widths, slack, strict=True) if free), default=0)
            at = next(k for k, free in enumerate(slack) if free and widths[k] == widest)
            widths[at] -= 1
        for column, width in zip(self.columns, widths, strict=True):
            column.width = width
        yield from super().__rich_console__(console, options)

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """Take the width there is."""
        return Measurement(options.max_width, options.max_width)

    def _stacked(self, cells: list[list[str]], width: int) -> list[str]:
        """Return each row as a line with its first cells, then its numbers with titles, as many as a line takes."""
        titles = [str(column.header) for column in self.columns]
        lines = []
        for row in zip(*cells, strict=True):
            plain = [k for k, column in enumerate(self.columns) if column.justify != "right" and k < 3]
            lines.append(" ".join(row[k] for k in plain if row[k]))
            rest = [k for k in range(len(row)) if k not in plain and row[k]]
            pieces = [f"{titles[k]}: {row[k]}" if titles[k] else row[k] for k in rest]
            lines += _packed(pieces, width)
        return lines


def _packed(pieces: list[str], width: int) -> list[str]:
    """Return pieces as indented lines, none of them broken where it fits a line."""
    lines: list[str] = []
    for piece in pieces:
        joined = f"{lines[-1]}   {piece}" if lines else ""
        if joined and cell_len(joined) <= width:
            lines[-1] = joined
        else:
            lines.append(f"  {piece}")
    return lines


def _least_width(column: Column, texts: list[str]) -> int:
    """Return the width of the longest text that must stay in a line: a word, or a whole number with its unit."""
    words = [word for text in [str(column.header), *texts] for word in text.split()]
    whole = texts if column.justify == "right" else words
    return max([cell_len(text) for text in (*words, *whole)], default=0)
