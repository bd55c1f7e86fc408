"""What `view` shows: the page that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import ViewResult
    from stiffcal.show.options import ShowOptions


def page(result: ViewResult, options: ShowOptions) -> Page:
    """Return where the page is, and how much of the campaign it shows."""
    made = PageBuilder("Page for a browser")
    if result.n_shown < result.n_states:
        text = f"{result.n_shown} of {result.n_states} load states are shown; errors are computed from all"
        made.say(text, "sample")
    made.say(f"view: {result.file}", "written")
    return made.page()
