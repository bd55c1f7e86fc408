"""What `plot` shows: the picture that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import PlotResult
    from stiffcal.show.options import ShowOptions


def page(result: PlotResult, options: ShowOptions) -> Page:
    """Return where the picture is."""
    made = PageBuilder("Picture")
    made.say(f"drew {result.drawn}: {result.file}", "written")
    return made.page()
