"""A table that splits no word on a narrow terminal: columns wrap between words; those without room stand below.

In a module of its own: it needs rich when it is defined, which the list of commands and their help do not load.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from itertools import pairwise

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.segment import Segment
from rich.table import Column, Table

GAP = 3
"""Columns of a terminal between two of a table."""


class NarrowTable(Table):
    """A table whose columns are as wide as their longest word at least; numbers (aligned right) are never wrapped.

    Columns without room stand in further parts below, each with the first column again. A column without a title (a
    unit, a remark) stays with the one before it. Before that, and before a cell wraps, secondary columns go, from the
    last on, and a line names them.
    """

    secondary: frozenset[int] = frozenset()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Draw as many parts as the width asks for."""
        titles = [str(column.header) for column in self.columns]
        cells = [[str(cell) for cell in column._cells] for column in self.columns]
        least = [_least_width(column, texts) for column, texts in zip(self.columns, cells, strict=True)]
        unwrapped = [max([width, *map(cell_len, texts)]) for width, texts in zip(least, cells, strict=True)]
        starts = [k for k, title in enumerate(titles) if k == 0 or title]
        groups = [list(range(a, b)) for a, b in pairwise([*starts, len(titles)])]
        room = options.max_width + GAP
        left_out: list[str] = []
        for group in [group for group in reversed(groups) if group[0] in self.secondary]:
            if sum(unwrapped[k] + GAP for kept in groups for k in kept) > room:
                # a unit that stands behind it belongs to the number before it
                groups[groups.index(group) - 1] += [k for k in group[1:] if k not in self.secondary]
                groups.remove(group)
                left_out.insert(0, titles[group[0]])
        parts = [groups[0].copy()] if groups else []
        for group in groups[1:]:
            if sum(least[k] + GAP for k in (*parts[-1], *group)) > room and parts[-1] != groups[0]:
                parts.append(groups[0].copy())
            parts[-1] += group
        for number, shown in enumerate(parts):
            if number:
                yield Segment.line()
            widths = {k: max([least[k], cell_len(titles[k]), *map(cell_len, cells[k])]) for k in shown}
            while sum(widths.values()) + GAP * len(shown) > room:
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
        if left_out:
            yield Segment(f"no room for: {'; '.join(left_out)}")
            yield Segment.line()

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """Take the width there is."""
        return Measurement(options.max_width, options.max_width)


def _least_width(column: Column, texts: list[str]) -> int:
    """Return the width of the longest text that must stay in a line: a word, or a whole number with its unit."""
    words = [word for text in [str(column.header), *texts] for word in text.split()]
    whole = texts if column.justify == "right" else words
    return max([cell_len(text) for text in (*words, *whole)], default=0)
