"""Pages of answers as a notebook shows them: HTML that carries all it needs."""

from __future__ import annotations

import html
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, assert_never

from stiffcal.presentation.bars import table_of
from stiffcal.presentation.pictures import Picture
from stiffcal.presentation.texts import printed_columns, printed_rows, text_of
from stiffcal.presentation.values import Bars, Block, Listing, Page, Sentence, Subheading, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def html_of(page: Page, warnings: Iterable[str] = ()) -> str:
    """Return a page as HTML.

    Parameters
    ----------
    page : what an answer shows. warnings : what a reader of the answer must know, a line each.

    Examples
    --------
    >>> html_of(Page("Fit", (Sentence(("rms < 1 µm",), "fit"),)))
    '<div>rms &lt; 1 µm</div>'
    """
    lines = [f"<div>Warning: {html.escape(text)}</div>" for text in warnings]
    then = [] if page.next_step is None else [f"<div>{html.escape(page.next_step.text)}</div>"]
    return "".join([*(_block(block) for block in page.blocks), *lines, *then])


def _block(block: Block) -> str:
    match block:
        case Sentence():
            return f"<div>{_sentence(block)}</div>"
        case Listing():
            return f"<ul>{''.join(f'<li>{_sentence(one)}</li>' for one in block.sentences)}</ul>"
        case Subheading():
            return f"<h4>{html.escape(block.text)}</h4>"
        case Table():
            return _table(block)
        case Bars():
            return _table(table_of(block))
        case Picture():
            return _picture(block)
        case _:
            assert_never(block)


def _sentence(sentence: Sentence) -> str:
    text = html.escape(text_of(sentence.words))
    if sentence.is_verdict:
        return f"<b>{sentence.level.upper()}</b> {text}"
    return f"Warning: {text}" if sentence.level == "warning" else text


def _table(table: Table) -> str:
    aligned = [f' style="text-align: {"right" if column.numbers else "left"}"' for column in table.columns]
    heads = [column.title + (f" [{unit}]" if unit else "") for column, unit in printed_columns(table)]
    rows = [_row("th", heads, aligned), *(_row("td", row, aligned) for row in printed_rows(table))]
    caption = f"<caption>{html.escape(table.caption)}</caption>" if table.caption else ""
    return f"<table>{caption}{''.join(rows)}</table>"


def _row(name: str, cells: Iterable[str], aligned: Iterable[str]) -> str:
    texts = zip(cells, aligned, strict=True)
    return f"<tr>{''.join(f'<{name}{style}>{html.escape(text)}</{name}>' for text, style in texts)}</tr>"


def svg_of(figure: Figure) -> str:
    """Return a picture as an element of HTML."""
    from stiffcal.report.figures.canvas import save_figure

    with tempfile.TemporaryDirectory(prefix="stiffcal-picture-") as folder:
        file = Path(folder) / "picture.svg"
        save_figure(figure, file)
        drawn = file.read_text(encoding="utf-8")
    return drawn[drawn.index("<svg") :]


def _picture(picture: Picture) -> str:
    from stiffcal.report.figures.panels import draw_panels

    return f"<div>{svg_of(draw_panels(picture))}</div><div>{html.escape(text_of(picture.caption))}</div>"
