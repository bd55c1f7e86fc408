"""The largest force of the campaign."""

from __future__ import annotations

from stiffcal.report.blocks import LeftOut, Paragraph, ReportSection
from stiffcal.report.content import ReportContent

ORDER = 25
_TITLE = "The largest force"


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out one sentence."""
    if content.states is None:
        return LeftOut(_TITLE, "there are no load states")
    return ReportSection(_TITLE, (Paragraph(f"No load exceeds {content.states.load.max():.0f} newtons."),))
