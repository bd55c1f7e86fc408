"""Campaigns of a batch in words, for the terminal, JUnit and Markdown."""

from __future__ import annotations

from stiffcal.diagnosis.answers.suspect_results import Suspect
from stiffcal.results.batch_results import HELD, NOT_HELD, AuthorChoice, BatchResult, CampaignOutcome

VERDICTS = {HELD: "held", NOT_HELD: "NOT held"}


def verdict_of(outcome: CampaignOutcome) -> str:
    """Return one word or two for a campaign's state."""
    if outcome.state == HELD and not outcome.checks:
        return "done"
    return VERDICTS.get(outcome.state, outcome.state)


def choice_text(choice: AuthorChoice) -> str:
    """Return a choice of a campaign's author as one line."""
    return f"{choice.kind}, {choice.place}: {choice.text}"


def suspect_text(suspect: Suspect) -> str:
    """Return a run or row that disagrees with all the others as one line."""
    row = "" if suspect.row is None else f", row {suspect.row}"
    return f"suspect run {suspect.run}{row} ({suspect.kind}): {suspect.likely}"


def complaints_of(outcome: CampaignOutcome) -> list[str]:
    """Return the failures and errors of a campaign, one line each."""
    if outcome.error is None:
        return list(outcome.failed)
    return [
        str(fault) if fault.file.startswith(outcome.folder) else f"{outcome.folder}: {fault}"
        for fault in (outcome.error, *outcome.others)
    ]


def totals_of(result: BatchResult) -> str:
    """Return the sentence that sums the batch up."""
    counts, workers, memory = result.counts, result.workers, result.peak_memory_bytes
    states = ", ".join(
        f"{number} {text}"
        for number, text in ((counts.held, "held"), (counts.not_held, "not held"), (counts.broken, "broken"))
        if number or text == "held"
    )
    kind = "process" if workers.count == 1 else "processes"
    workers_text = f"{workers.count} {kind}" if workers.kind == "processes" else f"{workers.count} threads of Dask"
    memory_text = f", at most {memory / 1e6:.0f} MB each" if memory else ""
    noun = "campaign" if counts.campaigns == 1 else "campaigns"
    return (
        f"{counts.campaigns} {noun}: {states}; {counts.unchanged} unchanged; {result.seconds:.1f} s with "
        f"{workers_text}{memory_text}"
    )


def number_of_suspects(outcome: CampaignOutcome) -> str:
    """Return how many runs and rows disagree with all the others; a dash where runs were not compared."""
    return "–" if outcome.suspects is None else str(len(outcome.suspects))
