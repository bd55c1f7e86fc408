"""Appendix: the runs with their joint angles, where they are many."""

from __future__ import annotations

from stiffcal.report.blocks import ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.sections.campaign import MOST_RUNS_HERE, runs_table

ORDER = 920


def section(content: ReportContent) -> ReportSection | None:
    """Lay out all runs; nothing where the campaign's own section lists them."""
    if len(content.runs) <= MOST_RUNS_HERE:
        return None
    return ReportSection("Appendix: the runs", (runs_table(content),))
