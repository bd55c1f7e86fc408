"""Pages of answers, and what kinds of experiment have to show, as people read them in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile
from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.masking import mask

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.presentation.pictures import Picture
    from stiffcal.presentation.values import Bars, Block, Column, Page, Table

_STYLES = {"pass": "bold green", "warn": "bold yellow", "fail": "bold red"}


def draw_page(console: AnswerConsole, page: Page, warnings: Iterable[str] = ()) -> None:
    """Draw the page of an answer; warnings come after its verdict, where it has one.

    Parameters
    ----------
    console : where to. page : what the answer shows. warnings : what a reader must know, for standard error.
    """
    from stiffcal.presentation.values import ORIGIN, Sentence

    def comes_first(block: Block) -> bool:
        return isinstance(block, Sentence) and (block.is_verdict or block.code == ORIGIN)

    first = list(takewhile(comes_first, page.blocks))
    draw_blocks(console, first)
    if first:
        console.show_warnings(warnings)
    draw_blocks(console, page.blocks[len(first) :])
    console.show_warnings(warnings)
    if page.next_step is not None:
        # Never wrapped: the line is there to be copied.
        console.out(f"\n{mask(page.next_step.text)}", highlight=False)


def draw_blocks(console: AnswerConsole, blocks: Iterable[Block]) -> None:
    """Draw sentences, tables, lists, bars, and of pictures the points, in characters."""
    from stiffcal.presentation.texts import text_of
    from stiffcal.presentation.values import Bars, Listing, Sentence, Subheading, Table

    for block in blocks:
        match block:
            case Sentence(level="pass" | "warn" | "fail" as level):
                _print_verdict(console, level, text_of(block.words))
            case Sentence(level="question") if not console.is_terminal:
                continue
            case Sentence():
                console.print("\n" * block.starts_paragraph + text_of(block.words), soft_wrap=True)
            case Subheading():
                console.print(f"\n{block.text}", style="bold" if block.is_title else None, soft_wrap=True)
            case Listing():
                for sentence in block.sentences:
                    console.print(f"  {text_of(sentence.words)}", soft_wrap=True)
            case Table():
                _draw_table(console, block)
            case Bars():
                _draw_bars(console, block)
            case _:
                _draw_picture(console, block)


def _print_verdict(console: AnswerConsole, level: str, text: str) -> None:
    """Print a verdict: its word in its colour at a terminal, the word alone in a pipe or with NO_COLOR."""
    from rich.text import Text

    line = Text.assemble((level.upper(), _STYLES[level]), "  ", text)
    console.print(line, soft_wrap=not console.is_terminal)


def _draw_table(console: AnswerConsole, table: Table) -> None:
    from stiffcal.presentation.texts import printed_columns, printed_rows

    headings = [_heading(column, unit) for column, unit in printed_columns(table)]
    drawn = plain_table(*headings, secondary=[k for k, column in enumerate(table.columns) if column.is_secondary])
    for row in printed_rows(table):
        drawn.add_row(*row)
    console.print(drawn)


def _draw_bars(console: AnswerConsole, bars: Bars) -> None:
    from stiffcal.cli.ladder_bars import WIDEST_LADDER, bar_lines

    _print_lines(console, bar_lines(bars, min(console.width, WIDEST_LADDER)))


def _draw_picture(console: AnswerConsole, picture: Picture) -> None:
    from stiffcal.cli.character_plot import plot_points
    from stiffcal.presentation.pictures import Marks

    for panel in picture.panels:
        for marks in panel.series:
            if isinstance(marks, Marks):
                labels = (panel.x_label, panel.y_label)
                _print_lines(console, ["", *plot_points(marks.x, marks.y, labels, console.width)])


def _print_lines(console: AnswerConsole, lines: Iterable[str]) -> None:
    for line in lines:
        console.print(line, no_wrap=True, overflow="ignore", crop=False)


def _heading(column: Column, unit: str) -> str:
    return f"{column.title}{f' [{unit}]' if unit else ''}{'>' if column.numbers else ''}"
