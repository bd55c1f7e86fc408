"""Where every number comes from: versions, settings, and the files that were read, with their digests."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.report import wording
from stiffcal.report.blocks import Facts, Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.report.provenance_content import ReportSource

ORDER = 990
_TITLE = "Origin of this report"


def section(content: ReportContent) -> ReportSection:
    """Lay out campaign, versions, settings, and the files with size and SHA-256."""
    origin = content.provenance
    rows = [("campaign", origin.campaign), ("robot", origin.robot), ("date", origin.date)]
    if origin.versions:
        rows.append(("made with", ", ".join(f"{name} {version}" for name, version in origin.versions)))
    if origin.settings:
        rows.append(("settings", ", ".join(f"{name}: {value}" for name, value in origin.settings)))
    rows.append(("in a browser", "stiffcal view DIR writes these results as an interactive page"))
    files = (sources_table(origin.sources),) if origin.sources else (Paragraph("The store lists no source files."),)
    return ReportSection(_TITLE, (Facts(tuple(rows)), *files))


def sources_table(sources: Sequence[ReportSource]) -> TableBlock:
    """Return the table of files with size and SHA-256."""
    columns = (
        TableColumn("file", align="left", width=1.0),
        TableColumn("size", "kB"),
        TableColumn("SHA-256", align="left", mono=True),
    )
    rows = tuple((source.file, wording.significant(source.n_bytes / 1e3), source.sha256) for source in sources)
    caption = (
        "Files on which the results are based. A file with another SHA-256 is not the file that was evaluated here."
    )
    return TableBlock(columns, rows, caption)
