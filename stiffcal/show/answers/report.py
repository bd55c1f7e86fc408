"""What `report` shows: the file that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import ReportResult
    from stiffcal.show.options import ShowOptions


def page(result: ReportResult, options: ShowOptions) -> Page:
    """Return where the PDF is."""
    made = PageBuilder("Report")
    made.say(f"report: {result.file}", "written")
    return made.page()
