"""`stiffcal batch`: many campaigns in parallel, one summary, for CI."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, NextLine, answering
from stiffcal.cli.ended_in_order import ended_in_order
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import AsJson, Overwrite, StoreAt, Thresholds
from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import Level, show_verdict
from stiffcal.cli.wording import deviation, share
from stiffcal.escapes.shell import command_line
from stiffcal.results.next_step import is_within_noise

if TYPE_CHECKING:
    from stiffcal.batch.results import BatchResult, CampaignOutcome
    from stiffcal.cli.console import AnswerConsole


def batch(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR...", help="Campaign folders, or folders that contain campaign folders.")
    ],
    jobs: Annotated[
        int | None,
        typer.Option(
            "--jobs", metavar="N", min=1, help="Number of processes (default: one per core).", show_default=False
        ),
    ] = None,
    thresholds: Thresholds = None,
    junit: Annotated[
        Path | None, typer.Option("--junit", metavar="FILE", help="Write the summary as JUnit XML.")
    ] = None,
    markdown: Annotated[
        Path | None,
        typer.Option(
            "--markdown", metavar="FILE", help="Write the summary as Markdown, for the summary page of a CI job."
        ),
    ] = None,
    reports: Annotated[
        Path | None, typer.Option("--reports", metavar="FOLDER", help="Folder for the PDFs (default: DIR/report.pdf).")
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no PDFs.")] = False,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Run on this Dask cluster (needs distributed)."),
    ] = None,
    idle_timeout: Annotated[
        float,
        typer.Option(
            "--idle-timeout",
            metavar="SECONDS",
            min=1.0,
            help="Give a campaign up whose process makes no progress for this long.",
        ),
    ] = 600.0,
    as_json: AsJson = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """Run many campaigns in parallel and check them against thresholds.

    Ingests, identifies, validates and reports each; unchanged campaigns are not computed again.
    Exit code 1 if a threshold is not met or a campaign is wrong; the other campaigns still run.

    Example: stiffcal batch campaigns/hidden --thresholds thresholds.toml --junit junit.xml --markdown summary.md
    """
    with answering(as_json) as answer:
        from stiffcal.batch.campaigns import BatchOptions, batch_campaigns
        from stiffcal.batch.summary import junit_text, markdown_text, prepare_files, write_summary
        from stiffcal.trust.output_kinds import JUNIT, MARKDOWN

        prepare_files(markdown, junit, overwrite=overwrite)
        printer = _BatchPrinter(answer)
        batch_options = BatchOptions(
            jobs,
            thresholds,
            store,
            reports,
            not no_report,
            scheduler,
            idle_timeout,
            progress=answer.progress,
            finished=printer.finished,
            overwrite=overwrite,
        )
        try:
            with ended_in_order():
                result = batch_campaigns(folders, batch_options)
        except KeyboardInterrupt:
            answer.notify(printer.interrupted())
            raise
        for file, kind, text in ((junit, JUNIT, junit_text), (markdown, MARKDOWN, markdown_text)):
            if file is not None:
                write_summary(text(result), file, kind, overwrite=overwrite)
        answer.give(result, show_batch, _next(result, store))
    return OK if result.passed else NOT_HELD


class _BatchPrinter:
    """Messages while the batch runs: a line per campaign where no bar is drawn."""

    def __init__(self, answer: Answer) -> None:
        self._answer = answer
        self._lines = not sys.stderr.isatty()
        self._done = self._of = 0

    def finished(self, outcome: CampaignOutcome, done: int, of: int) -> None:
        from stiffcal.batch.summary import verdict_of

        self._done, self._of = done, of
        if self._lines:
            took = f"{outcome.seconds:.1f} s"
            self._answer.notify(f"{done} of {of}: {outcome.campaign}: {verdict_of(outcome)}, {took}")

    def interrupted(self) -> str:
        done = f"{self._done} of {self._of} campaigns are" if self._of else "no campaign is"
        return f"{done} done; the same command continues with the rest"


def show_batch(console: AnswerConsole, result: BatchResult) -> None:
    """Draw the summary: the totals, what does not hold or cannot be judged, then a row per campaign."""
    from stiffcal.batch.summary import (
        choice_text,
        complaints_of,
        number_of_suspects,
        suspect_text,
        totals_of,
        verdict_of,
    )

    show_verdict(console, _level(result), totals_of(result))
    for outcome in result.campaigns:
        for line in complaints_of(outcome):
            console.print(f"  {outcome.campaign}: {verdict_of(outcome)}: {line}", soft_wrap=True)
        for line in outcome.not_judged:
            console.print(f"  {outcome.campaign}: not judged: {line}", soft_wrap=True)
    console.show_warnings(result.warnings)
    headings = ("rms in held-out data>", "of the deflection>", "noise>", "suspects>")
    table = plain_table("campaign", "verdict", *headings, "computed")
    for number, column in enumerate(table.columns):
        column.no_wrap = number not in (2, 4)  # errors of several measures wrap, names do not
    for outcome in result.campaigns:
        steps = outcome.steps
        done = [name for name, step in steps.items() if step.done]
        unchanged = "unchanged, not run again" if outcome.error is None else "nothing"
        computed = "all" if len(done) == len(steps) > 1 else ", ".join(done) or unchanged
        relative = None if outcome.relative is None else outcome.relative.translation
        table.add_row(
            outcome.campaign,
            verdict_of(outcome),
            deviation(outcome.rms),
            share(relative),
            "not known" if outcome.noise is None else deviation(outcome.noise),
            number_of_suspects(outcome),
            computed,
        )
    console.print(table)
    for outcome in result.campaigns:
        for suspect in outcome.suspects or ():
            console.print(f"{outcome.campaign}: {suspect_text(suspect)}", soft_wrap=True, markup=False)
    for outcome in result.campaigns:
        for choice in outcome.choices:
            console.print(f"{outcome.campaign}: chosen: {choice_text(choice)}", soft_wrap=True)


def _level(result: BatchResult) -> Level:
    """Return how a batch stands: fail as its exit code is, warn where a campaign has suspects or was not judged."""
    if not result.passed:
        return "fail"
    return "warn" if any(entry.not_judged or entry.suspects for entry in result.campaigns) else "pass"


def _next(result: BatchResult, store: str | None) -> NextLine:
    """Return the step that the worst campaign asks for."""
    from stiffcal.batch.campaigns import store_below

    for outcome in result.campaigns:
        if outcome.error is not None:
            line = command_line("check", Path(outcome.folder))
            return NextLine(line, once="what is wrong there is corrected")
    above = [entry for entry in result.campaigns if entry.rms is None or not is_within_noise(entry.rms, entry.noise)]
    failed = [entry for entry in result.campaigns if entry.failed]
    first = (failed or above or result.campaigns)[0]
    own = store_below(store, first.campaign) if store else None
    return NextLine(command_line("diagnose" if failed or above else "view", Path(first.folder), store=own))
