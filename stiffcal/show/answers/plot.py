"""What `plot` shows: the picture that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import PlotResult


def page(result: PlotResult, details: bool) -> Page:
    """Return where the picture is."""
    made = PageBuilder("Picture")
    made.say(f"drew {result.drawn}: {result.file}", "written")
    return made.page()
