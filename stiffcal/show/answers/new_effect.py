"""What `effects new` shows: the file that was written, and what it tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import NewEffectResult
    from stiffcal.show.options import ShowOptions


def page(result: NewEffectResult, options: ShowOptions) -> Page:
    """Return what was written, and what it tests."""
    made = PageBuilder("New effect")
    made.say(f"wrote {result.file}: {result.effect}, which tests whether {result.tests}", "written")
    text = "campaign.toml lists it under plugins; read it, then allow it; diagnose tries it from then on"
    made.say(text, "to-allow")
    return made.page()
