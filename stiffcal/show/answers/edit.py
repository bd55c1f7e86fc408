"""What `add` and `remove` show: what changed in model.toml, and what it holds now."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.results.model_words import model_words
from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import EditResult
    from stiffcal.show.options import ShowOptions


def page(result: EditResult, options: ShowOptions) -> Page:
    """Return what changed and what the model holds now."""
    made = PageBuilder("Model")
    for line in result.changes:
        made.say(line, "model")
    made.say(f"model now: {model_words(result.model)}, not fitted yet", "model")
    return made.page()
