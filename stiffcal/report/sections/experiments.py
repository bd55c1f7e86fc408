"""What kinds of experiment show, a section each, whatever the kind."""

from __future__ import annotations

from stiffcal.report.blocks import LeftOut, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.page_blocks import section_of

ORDER = 44


def section(content: ReportContent) -> tuple[ReportSection | LeftOut, ...]:
    """Lay out the pages of all kinds of experiment that the campaign holds."""
    return tuple(section_of(page) for page in content.pages)
