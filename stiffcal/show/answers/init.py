"""What `init` shows: the files that were written, what was guessed, what is left to be written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder
from stiffcal.wording import count, listing

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.command_results import InitResult
    from stiffcal.show.options import ShowOptions

MOST_FILES = 10
MOST_GUESSES = 10


def page(result: InitResult, options: ShowOptions) -> Page:
    """Return the files that were written, the lines that were guessed, and those that are left to be written."""
    made = PageBuilder("New campaign")
    for file in result.files[:MOST_FILES]:
        made.say(f"wrote {file}", "written")
    if len(result.files) > MOST_FILES:
        made.say(f"wrote {len(result.files) - MOST_FILES} more files", "written")
    if result.runs:
        made.say(f"{count(len(result.runs), 'run')}: {listing(result.runs)}", "runs")
    guessed = result.guessed
    if guessed:
        made.say("guessed, please check these lines (`# ?`):", "guessed")
        for line in guessed[:MOST_GUESSES]:
            made.say(f"  {line}", "guessed")
        if len(guessed) > MOST_GUESSES:
            made.say(f"  and {len(guessed) - MOST_GUESSES} more lines with `# ?` (all in --json)", "guessed")
    if result.to_write:
        made.say("to be written, as no log states it:", "to-write")
        for line in result.to_write:
            made.say(f"  {line}", "to-write")
    return made.page()
