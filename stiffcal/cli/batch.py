"""`stiffcal batch`: many campaigns in parallel, one summary, for CI."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.ended_in_order import ended_in_order
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import AsJson, Overwrite, StoreAt, Thresholds
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep
from stiffcal.results.next_step import is_within_noise

if TYPE_CHECKING:
    from stiffcal.results.batch_results import BatchResult, CampaignOutcome


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
        answer.show(result, _next(result, store))
    return OK if result.passed else NOT_HELD


class _BatchPrinter:
    """Messages while the batch runs: a line per campaign where no bar is drawn."""

    def __init__(self, answer: Answer) -> None:
        self._answer = answer
        self._lines = not sys.stderr.isatty()
        self._done = self._of = 0

    def finished(self, outcome: CampaignOutcome, done: int, of: int) -> None:
        from stiffcal.results.batch_words import verdict_of

        self._done, self._of = done, of
        if self._lines:
            took = f"{outcome.seconds:.1f} s"
            self._answer.notify(f"{done} of {of}: {outcome.campaign}: {verdict_of(outcome)}, {took}")

    def interrupted(self) -> str:
        done = f"{self._done} of {self._of} campaigns are" if self._of else "no campaign is"
        return f"{done} done; the same command continues with the rest"


def _next(result: BatchResult, store: str | None) -> NextStep:
    """Return the step that the worst campaign asks for."""
    from stiffcal.batch.campaigns import store_below

    for outcome in result.campaigns:
        if outcome.error is not None:
            line = command_line("check", Path(outcome.folder))
            return NextStep(line, once="what is wrong there is corrected")
    above = [entry for entry in result.campaigns if entry.rms is None or not is_within_noise(entry.rms, entry.noise)]
    failed = [entry for entry in result.campaigns if entry.failed]
    first = (failed or above or result.campaigns)[0]
    own = store_below(store, first.campaign) if store else None
    return NextStep(command_line("diagnose" if failed or above else "view", Path(first.folder), store=own))
