"""`stiffcal improve`: diagnose, add, identify, until nothing is missing."""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.improve_dialog import ImproveDialog
from stiffcal.cli.ladder_bars import LiveLadder
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Overwrite, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step
from stiffcal.show.ladder import step_in_words
from stiffcal.show.options import ShowOptions
from stiffcal.validation.schemes import held_out
from stiffcal.wording import deviation

if TYPE_CHECKING:
    from collections.abc import Callable

    from stiffcal.results.improve_results import ImproveStep


def improve(
    folder: Folder = HERE,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask for confirmation.")] = False,
    likely: Annotated[
        bool, typer.Option("--likely", help="Add what is probable (0.5 and more) too, not only what is certain.")
    ] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only show what would be added and removed.")] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    report: Annotated[
        bool | None,
        typer.Option(
            "--report/--no-report",
            help="Write page and report anew if the model was changed (default: at a terminal).",
            show_default=False,
        ),
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Add what is missing, step by step, then remove what was added and is not needed.

    Without questions only what is certain is added. At a terminal and without --yes it shows the reason, the expected
    error and the look-alikes before each step, and asks: yes, another effect, details, skip or quit. There it also
    writes DIR/view.html and DIR/report.pdf anew if the model was changed.

    Example: stiffcal improve demo --yes
    """
    with answering(as_json) as answer:
        from stiffcal.commands.improve import always, improve_campaign
        from stiffcal.commands.improve_pages import check_pages, with_pages
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store,
            update=not no_update,
            progress=answer.progress,
            notify=answer.notify,
            overwrite=overwrite,
        )
        at_terminal = sys.stdout.isatty() and not as_json
        if report:
            check_pages(folder, context)
        asks = sys.stdin.isatty() and not yes and not as_json
        ask = ImproveDialog(answer.notify) if asks else always
        result = improve_campaign(folder, context, ask, dry_run, _step_shown(answer, at_terminal), likely or asks)
        answer.progress.above = None
        if at_terminal if report is None else report:
            result = with_pages(result, folder, context)
        after = Step.DIAGNOSE if dry_run else Step.IMPROVE
        done = {Step.REPORT} if result.report else set()
        answer.show(result, following(folder, store, after, done), ShowOptions(folder=folder, store=store))
    return OK


def _step_shown(answer: Answer, at_terminal: bool) -> Callable[[ImproveStep], None] | None:
    """Return what shows a step as it is reached: a ladder that grows at a terminal, else a line; None with --json."""
    if answer.as_json:
        return None
    if not (at_terminal and answer.progress.is_drawn):
        return partial(print_step, answer)
    ladder = LiveLadder()
    answer.progress.above = ladder
    return ladder.reached


def print_step(answer: Answer, step: ImproveStep) -> None:
    """Print a rung of the ladder as it is reached."""
    answer.notify(f"{step_in_words(step)}: {deviation(step.heldout_rms)} rms in {held_out(step.scheme)}")
