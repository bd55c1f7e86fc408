"""From content to PDF: lay out the sections, draw their pictures, set the pages."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import Any

from stiffcal.errors import Progress, no_progress
from stiffcal.report.blocks import (
    Block,
    Facts,
    Items,
    LeftOut,
    NumbersBlock,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    VerdictBlock,
)
from stiffcal.report.content import ReportContent
from stiffcal.report.drawing import Picture, draw_pictures
from stiffcal.report.sections import all_sections
from stiffcal.report.typesetting import set_pages
from stiffcal.report.wording import DASH

_LOGO_FILE = "logo.png"


def build_report(
    content: ReportContent, output: Path, progress: Progress = no_progress, is_short: bool = False
) -> None:
    """Write the report as a PDF; the same content gives the same bytes.

    Parameters
    ----------
    content : finished results of the other rooms.
    output : where to write, when the report is complete.
    progress : receives each picture's name.
    is_short : the pages for a customer alone: the answer, values, limits and signatures.

    Raises
    ------
    OSError : it cannot be written.
    """
    heading = PagesHeading(
        title=_title(content),
        kind=_kind(content),
        campaign=content.provenance.campaign,
        date=content.provenance.date,
        maker=" ".join(content.provenance.versions[0]) if content.provenance.versions else "stiffcal",
        has_contents=not is_short,
    )
    write_pages(heading, lay_out(content, is_short), output, progress, content.logo)
    progress("report written", 1.0)


@dataclass(frozen=True)
class PagesHeading:
    """What stands above pages, and on each of them."""

    title: str
    """Printed large."""
    kind: str
    """The work that the pages are about, under the title."""
    campaign: str
    """Its name."""
    date: str
    """ISO date, which the PDF carries as its own."""
    maker: str
    """What made the pages."""
    has_contents: bool = True
    """Whether the sections are listed after the first one."""


def write_pages(
    heading: PagesHeading, sections: Sequence[ReportSection], output: Path, progress: Progress, logo: bytes = b""
) -> None:
    """Write sections as a PDF; the same content gives the same bytes.

    Parameters
    ----------
    heading : title and date.
    sections : in order.
    output : where to write, when the pages are complete.
    progress : receives each picture's name.
    logo : PNG next to the title; empty for none.

    Raises
    ------
    OSError : it cannot be written.
    """
    with tempfile.TemporaryDirectory(prefix="stiffcal-report-") as folder:
        pages = {**asdict(heading), "sections": _as_data(sections, Path(folder), progress)}
        pages["logo"] = _LOGO_FILE if logo else ""
        if logo:
            (Path(folder) / _LOGO_FILE).write_bytes(logo)
        progress("typesetting", 0.95)
        output.write_bytes(set_pages(pages, Path(folder), heading.date))


def _title(content: ReportContent) -> str:
    robot = content.provenance.robot
    subject = content.readings_alone[0].subject_of_model if len(content.readings_alone) == 1 else ""
    return f"{subject or 'Stiffness'} of {robot}"


def _kind(content: ReportContent) -> str:
    """Return the line under the title: the work that the report is about."""
    if content.absolute_alone:
        return "Calibration by absolute poses"
    if content.states is not None:
        return "Load-deflection calibration"
    text = ", and ".join(page.subject for page in content.readings_alone or content.pages)
    return f"{text[:1].upper()}{text[1:]}"


def lay_out(content: ReportContent, is_short: bool = False) -> list[ReportSection]:
    """Lay out all sections that have something to show; the last one ends with the others, and the reason.

    Parameters
    ----------
    content : as of `build_report`. is_short : those for a customer alone, and no reasons.
    """
    sections: list[ReportSection] = []
    left_out: list[LeftOut] = []
    for module in all_sections():
        if is_short and not getattr(module, "IN_SHORT", False):
            continue
        laid_out = module.section(content)
        for made in laid_out if isinstance(laid_out, tuple) else (laid_out,):
            if isinstance(made, LeftOut):
                left_out.append(made)
            elif made is not None:
                sections.append(made)
    if left_out and sections and not is_short:
        by_reason = attrgetter("reason")
        alike = groupby(sorted(left_out, key=by_reason), by_reason)
        listed = "; ".join(f"{', '.join(one.title for one in group)} ({reason})" for reason, group in alike)
        sections[-1] = replace(sections[-1], blocks=(*sections[-1].blocks, Paragraph(f"Left out: {listed}.", "quiet")))
    return sections


def _as_data(sections: Sequence[ReportSection], folder: Path, progress: Progress) -> list[dict[str, Any]]:
    """Turn sections into what the template reads, drawing each picture into `folder`."""
    pictures: list[Picture] = []
    data = []
    for section in sections:
        blocks = []
        for block in section.blocks:
            if isinstance(block, PictureBlock):
                number = len(pictures)
                name = f"figure-{number + 1:03d}.svg"
                pictures.append((f"drawing: {section.title}", block.draw, folder / name))
                blocks.append({"kind": "picture", "file": name, "number": number, "caption": block.caption})
            else:
                blocks.append(_block_data(block))
        data.append({"title": section.title, "blocks": blocks})
    draw_pictures(pictures, progress)
    return data


def _without_empty_columns(table: TableBlock) -> TableBlock:
    """Return a table without columns in which no row has anything."""
    shown = [k for k in range(len(table.columns)) if any(row[k] not in ("", DASH) for row in table.rows)]
    rows = tuple(tuple(row[k] for k in shown) for row in table.rows)
    return TableBlock(
        tuple(table.columns[k] for k in shown), rows, table.caption,
        tuple((row, shown.index(k)) for row, k in table.doubtful if k in shown),
    )  # fmt: skip


def _block_data(block: Block) -> dict[str, Any]:
    kinds = {
        Paragraph: "paragraph",
        VerdictBlock: "verdict",
        NumbersBlock: "numbers",
        Items: "items",
        SubheadingBlock: "subheading",
        Facts: "facts",
        TableBlock: "table",
    }
    shown = _without_empty_columns(block) if isinstance(block, TableBlock) and block.rows else block
    return {"kind": kinds[type(block)], **asdict(shown)}
