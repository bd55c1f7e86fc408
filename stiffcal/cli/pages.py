"""Pages of answers, and what kinds of experiment have to show, as people read them in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile
from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import show_verdict

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.presentation.values import Block, Column, Page, Table


def draw_page(console: AnswerConsole, page: Page, warnings: Iterable[str] = ()) -> None:
    """Draw the page of an answer; warnings come after its verdict, where it has one.

    Parameters
    ----------
    console : where to. page : what the answer shows. warnings : what a reader must know, for standard error.
    """
    from stiffcal.presentation.values import Sentence

    first = list(takewhile(lambda block: isinstance(block, Sentence) and block.is_verdict, page.blocks))
    draw_blocks(console, first)
    if first:
        console.show_warnings(warnings)
    draw_blocks(console, page.blocks[len(first) :])


def draw_blocks(console: AnswerConsole, blocks: Iterable[Block]) -> None:
    """Draw sentences, tables and lists; pictures are for media that have them."""
    from stiffcal.presentation.texts import text_of
    from stiffcal.presentation.values import Listing, Sentence, Subheading, Table

    for block in blocks:
        match block:
            case Sentence(level="pass" | "warn" | "fail" as level):
                show_verdict(console, level, text_of(block.words))
            case Sentence(level="question") if not console.is_terminal:
                continue
            case Sentence():
                console.print(text_of(block.words), soft_wrap=True)
            case Subheading():
                console.print(f"\n{block.text}", soft_wrap=True)
            case Listing():
                for sentence in block.sentences:
                    console.print(f"  {text_of(sentence.words)}", soft_wrap=True)
            case Table():
                _draw_table(console, block)


def _draw_table(console: AnswerConsole, table: Table) -> None:
    from stiffcal.presentation.texts import printed_columns, printed_rows

    headings = [_heading(column, unit) for column, unit in printed_columns(table)]
    drawn = plain_table(*headings, secondary=[k for k, column in enumerate(table.columns) if column.is_secondary])
    for row in printed_rows(table):
        drawn.add_row(*row)
    console.print(drawn)


def _heading(column: Column, unit: str) -> str:
    return f"{column.title}{f' [{unit}]' if unit else ''}{'>' if column.numbers else ''}"
