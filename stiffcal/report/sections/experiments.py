"""What kinds of experiment show, a section each: their sentences, tables and pictures, whatever the kind."""

from __future__ import annotations

from functools import partial
from typing import assert_never

from stiffcal.kinds import presentation
from stiffcal.kinds.presentation import Page, Sentence
from stiffcal.kinds.texts import printed_columns, printed_rows, text_of
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
    columns = tuple(
        Column(column.title, unit, align="right" if column.numbers else "left")
        for column, unit in printed_columns(table)
    )
    return TableBlock(columns, printed_rows(table), caption)
