"""What kinds of experiment show, a section each: their sentences, tables and pictures, whatever the kind."""

from __future__ import annotations

from functools import partial
from typing import assert_never

from stiffcal.kinds import presentation
from stiffcal.kinds.presentation import Digits, Interval, Joints, Names, Page, Sentence, Words
from stiffcal.printed_units import printed_unit
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Items,
    LeftOut,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
)
from stiffcal.report.blocks import TableColumn as Column
from stiffcal.report.content import ReportContent
from stiffcal.report.estimates import estimate_text
from stiffcal.report.figures.panels import draw_panels

ORDER = 44


def section(content: ReportContent) -> tuple[ReportSection | LeftOut, ...]:
    """Lay out the pages of all kinds of experiment that the campaign holds."""
    return tuple(_section_of(page) for page in content.pages)


def _section_of(page: Page) -> ReportSection | LeftOut:
    if not page.blocks:
        return LeftOut(page.title, page.why_empty)
    return ReportSection(page.title, tuple(_block(block) for block in page.blocks))


def _block(block: presentation.Block) -> Block:
    match block:
        case Sentence():
            return Paragraph(text_of(block.words))
        case presentation.Listing():
            return Items(tuple(text_of(sentence.words) for sentence in block.sentences))
        case presentation.Subheading():
            return SubheadingBlock(block.text)
        case presentation.Table():
            return table_of(block, block.caption)
        case presentation.Picture():
            return PictureBlock(partial(draw_panels, block), text_of(block.caption))
        case _:
            assert_never(block)


def table_of(table: presentation.Table, caption: str) -> TableBlock:
    """Return a table of a kind of experiment as the report sets it, in the units that people read."""
    units = [printed_unit(column.unit) for column in table.columns]
    columns = tuple(
        Column(column.title, unit, align="right" if column.numbers else "left")
        for column, (unit, _) in zip(table.columns, units, strict=True)
    )
    rows = tuple(
        tuple(text_of(cell, factor) for cell, (_, factor) in zip(row, units, strict=True)) for row in table.rows
    )
    return TableBlock(columns, rows, caption)


def text_of(words: Words, scale: float = 1.0) -> str:
    """Return a text with its numbers, times `scale`, as the report writes them.

    Examples
    --------
    >>> text_of((Names(("A1", "A2")), ": ", Digits(-0.12345), " N·m, ", Interval(2.0, 1.0, 3.5)))
    'A1 and A2: −0.123 N·m, 2.0 (1.0 … 3.5)'
    """
    text = ""
    for piece in words:
        match piece:
            case Digits(value, significant):
                text += wording.significant(None if value is None else value * scale, significant)
            case Interval(value, low, high):
                text += estimate_text(value, (low, high), scale)
            case Names(names):
                text += wording.listing(names)
            case Joints(joints):
                text += wording.place({"joints": list(joints)})
            case _:
                text += piece
    return text
