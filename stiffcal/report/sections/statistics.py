"""Appendix: the pictures that show whether the statistics of the fit hold."""

from __future__ import annotations

from stiffcal.report.blocks import PictureBlock, ReportSection
from stiffcal.report.content import ReportContent

ORDER = 915


def section(content: ReportContent) -> ReportSection | None:
    """Lay out residuals against a normal law, influence of runs, profiles and correlations."""
    if not content.statistics:
        return None
    blocks = tuple(PictureBlock(one, one.caption) for one in content.statistics)
    return ReportSection("Appendix: statistics of the fit", blocks)
