"""What `export` shows: the file that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import ExportResult
    from stiffcal.show.options import ShowOptions


def page(result: ExportResult, options: ShowOptions) -> Page:
    """Return the file and what is in it."""
    made = PageBuilder("Export")
    made.say(f"wrote {result.file}: {result.holds}", "written")
    return made.page()
