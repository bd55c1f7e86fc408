"""What `simulate` shows: the folder that was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import SimulateResult


def page(result: SimulateResult, details: bool) -> Page:
    """Return the folder and what is in it."""
    made = PageBuilder("Simulation")
    made.say(f"wrote {len(result.files)} files to {result.folder}", "written")
    return made.page()
