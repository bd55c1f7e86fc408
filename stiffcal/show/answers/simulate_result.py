"""What `simulate` shows: the folder that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import SimulateResult
    from stiffcal.show.options import ShowOptions


def page(result: SimulateResult, options: ShowOptions) -> Page:
    """Return the folder and what is in it."""
    made = PageBuilder("Simulation")
    made.say(f"wrote {len(result.files)} files to {result.folder}", "written")
    return made.page()
