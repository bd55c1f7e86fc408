"""Where every number comes from: the files that were read, with their digests."""

from __future__ import annotations

from stiffcal.report import wording
from stiffcal.report.blocks import Column, LeftOut, Section, Table
from stiffcal.report.content import ReportContent

ORDER = 900
_TITLE = "Sources"


def section(content: ReportContent) -> Section | LeftOut:
    """Lay out the files with size and SHA-256."""
    sources = content.provenance.sources
    if not sources:
        return LeftOut(_TITLE, "the store names no source files")
    columns = (
        Column("file", align="left", width=1.0), Column("size", "kB"), Column("SHA-256", align="left", mono=True),
    )  # fmt: skip
    rows = tuple((each.file, wording.digits(each.n_bytes / 1e3), each.sha256) for each in sources)
    caption = "Files that the results rest on. A file with another SHA-256 is not the file that was evaluated here."
    return Section(_TITLE, (Table(columns, rows, caption),))
