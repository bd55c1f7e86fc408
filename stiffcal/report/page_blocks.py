"""Pages of answers and of kinds of experiment as blocks of a PDF: their sentences, tables and pictures."""

from __future__ import annotations

from functools import partial
from typing import assert_never

from stiffcal.presentation import bars, values
from stiffcal.presentation.pictures import Picture
from stiffcal.presentation.texts import printed_columns, printed_rows, text_of
from stiffcal.report.blocks import (
    Block,
    Items,
    LeftOut,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.figures.panels import draw_panels
from stiffcal.report.wording import capital


def section_of(page: values.Page) -> ReportSection | LeftOut:
    """Return a page as a section; where it has nothing to show, the reason."""
    if not page.blocks:
        return LeftOut(page.title, page.why_empty)
    then = () if page.next_step is None else (Paragraph(capital(page.next_step.text)),)
    return ReportSection(page.title, (*map(block_of, page.blocks), *then))


def block_of(block: values.Block) -> Block:
    """Return a block as the report sets it: a sentence, a point and a heading begin with a capital letter."""
    match block:
        case values.Sentence():
            return Paragraph(capital(text_of(block.words)), "key" if block.is_verdict else "plain")
        case values.Listing():
            return Items(tuple(capital(text_of(sentence.words)) for sentence in block.sentences))
        case values.Subheading():
            return SubheadingBlock(capital(block.text))
        case values.Table():
            return table_of(block, block.caption)
        case values.Bars():
            return table_of(bars.table_of(block), "")
        case Picture():
            return PictureBlock(partial(draw_panels, block), text_of(block.caption))
        case _:
            assert_never(block)


def table_of(table: values.Table, caption: str) -> TableBlock:
    """Return a table as the report sets it, in the units that people read."""
    columns = tuple(
        TableColumn(column.title, unit, align="right" if column.numbers else "left", width=float(column.is_wide))
        for column, unit in printed_columns(table)
    )
    rows = printed_rows(table)
    if any(column.is_wide for column in table.columns):
        # the errors of several measures stand one under the other: side by side they leave no room for the words
        rows = tuple(
            tuple(
                cell.replace(", ", ",\n") if column.numbers else cell
                for column, cell in zip(table.columns, row, strict=True)
            )
            for row in rows
        )
    return TableBlock(columns, rows, caption)
