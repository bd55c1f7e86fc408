"""Where every number comes from: the files that were read, with their digests."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.report import wording
from stiffcal.report.blocks import LeftOut, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent, ReportSource

ORDER = 900
_TITLE = "Sources"
FIRST_PAGE_HOLDS = 12


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out the files with size and SHA-256; a few stand on the first page already."""
    sources = content.provenance.sources
    if not sources:
        return LeftOut(_TITLE, "the store names no source files")
    return ReportSection(_TITLE, (sources_table(sources),)) if len(sources) > FIRST_PAGE_HOLDS else None


def sources_table(sources: Sequence[ReportSource]) -> TableBlock:
    """Return the table of files with size and SHA-256."""
    columns = (
        TableColumn("file", align="left", width=1.0),
        TableColumn("size", "kB"),
        TableColumn("SHA-256", align="left", mono=True),
    )
    rows = tuple((source.file, wording.digits(source.n_bytes / 1e3), source.sha256) for source in sources)
    caption = "Files that the results rest on. A file with another SHA-256 is not the file that was evaluated here."
    return TableBlock(columns, rows, caption)
