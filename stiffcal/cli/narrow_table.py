"""A table that splits no word on a narrow terminal: columns wrap between words; those without room are named below it.

In a module of its own: it needs rich when it is defined, which the list of commands and their help do not load.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

from stiffcal.cli.console import wrapped

GAP = 3
"""Columns of a terminal between two of a table."""


class NarrowTable(Table):
    """A table whose columns are as wide as their longest word at least; numbers (aligned right) are never wrapped.

    Where not all of them fit, a column stays that fits next to those before it; the one that names the row and those
    without a title (units, remarks) always stay. A line under the table names what is not shown.
    """

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Draw as many columns as the width has room for."""
        cells = [[str(cell) for cell in column._cells] for column in self.columns]
        least = [_least_width(column, texts) for column, texts in zip(self.columns, cells, strict=True)]
        titles = [str(column.header) for column in self.columns]
        shown = [k for k, title in enumerate(titles) if k == 0 or not title]
        for k in range(len(titles)):
            if k not in shown and sum(least[at] + GAP for at in (*shown, k)) - GAP <= options.max_width:
                shown.append(k)
        shown.sort()
        hidden = [title for k, title in enumerate(titles) if k not in shown]
        widths = {k: max([least[k], cell_len(titles[k]), *map(cell_len, cells[k])]) for k in shown}
        room = options.max_width - GAP * (len(shown) - 1)
        while sum(widths.values()) > room:
            widest = max((k for k in shown if widths[k] > least[k]), key=lambda k: widths[k], default=None)
            if widest is None:
                break
            widths[widest] -= 1
        part = copy(self)
        part.columns = [
            replace(self.columns[k], _index=place, _cells=self.columns[k]._cells, width=widths[k])
            for place, k in enumerate(shown)
        ]
        yield from Table.__rich_console__(part, console, options)
        if hidden:
            text = f"  not shown on {options.max_width} columns: {', '.join(hidden)}"
            yield Text(wrapped(text, options.max_width), overflow="ignore", no_wrap=True)

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """Take the width there is."""
        return Measurement(options.max_width, options.max_width)


def _least_width(column: Column, texts: list[str]) -> int:
    """Return the width of the longest text that must stay in a line: a word, or a whole number with its unit."""
    words = [word for text in [str(column.header), *texts] for word in text.split()]
    whole = texts if column.justify == "right" else words
    return max([cell_len(text) for text in (*words, *whole)], default=0)
