"""What `batch` shows: the totals, what does not hold or cannot be judged, then a row per campaign."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.results.batch_words import (
    choice_text,
    complaints_of,
    number_of_suspects,
    suspect_text,
    totals_of,
    verdict_of,
)
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import deviation, share

if TYPE_CHECKING:
    from stiffcal.presentation.values import Level, Page
    from stiffcal.results.batch_results import BatchResult, CampaignOutcome
    from stiffcal.show.options import ShowOptions


def page(result: BatchResult, options: ShowOptions) -> Page:
    """Return the totals, the complaints, a row for each campaign, its suspects and what its author has chosen."""
    made = PageBuilder("Campaigns")
    made.say(totals_of(result), "verdict", _level(result))
    for outcome in result.campaigns:
        for line in complaints_of(outcome):
            made.say(f"  {outcome.campaign}: {verdict_of(outcome)}: {line}", "complaint")
        for line in outcome.not_judged:
            made.say(f"  {outcome.campaign}: not judged: {line}", "not-judged")
    numbers = ("rms in held-out data", "of the deflection", "noise", "suspects")
    made.table(("campaign", "verdict", *map(number, numbers), "computed"), map(_row, result.campaigns))
    for outcome in result.campaigns:
        for suspect in outcome.suspects or ():
            made.say(f"{outcome.campaign}: {suspect_text(suspect)}", "suspect")
    for outcome in result.campaigns:
        for choice in outcome.choices:
            made.say(f"{outcome.campaign}: chosen: {choice_text(choice)}", "chosen")
    return made.page()


def _row(outcome: CampaignOutcome) -> tuple[str, ...]:
    steps = outcome.steps
    done = [name for name, step in steps.items() if step.done]
    unchanged = "unchanged, not run again" if outcome.error is None else "nothing"
    return (
        outcome.campaign,
        verdict_of(outcome),
        deviation(outcome.rms),
        share(None if outcome.relative is None else outcome.relative.translation),
        "not known" if outcome.noise is None else deviation(outcome.noise),
        number_of_suspects(outcome),
        "all" if len(done) == len(steps) > 1 else ", ".join(done) or unchanged,
    )


def _level(result: BatchResult) -> Level:
    """Return how a batch stands: fail as its exit code is, warn where a campaign has suspects or was not judged."""
    if not result.passed:
        return "fail"
    return "warn" if any(entry.not_judged or entry.suspects for entry in result.campaigns) else "pass"
