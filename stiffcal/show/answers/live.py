"""What `view --live` shows once the page is served: its address, and how it ends."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import LiveResult
    from stiffcal.show.options import ShowOptions


def page(result: LiveResult, options: ShowOptions) -> Page:
    """Name the address."""
    made = PageBuilder("The page is served")
    made.say(f"open {result.address}", "address")
    if result.follows_logs:
        made.say("it follows the logs; what it reads of them is kept until it ends", "watch")
    made.say("Ctrl-C ends it; model.toml is changed only by the button on the page", "end")
    return made.page()
