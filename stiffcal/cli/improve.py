"""`stiffcal improve`: diagnose, add, identify, until nothing is missing."""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.before_after import show_moved
from stiffcal.cli.endings import OK
from stiffcal.cli.improve_dialog import ImproveDialog
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, StoreAt
from stiffcal.cli.registration import show_registration
from stiffcal.cli.suspects import show_suspects
from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import diagnosis_level, show_verdict
from stiffcal.cli.wording import NOT_KNOWN, deviation, places
from stiffcal.results.next_step import Step
from stiffcal.validation.schemes import held_out
from stiffcal.wording import variable

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.workflow.improve_results import ImproveResult, ImproveStep


def improve(
    folder: Folder = HERE,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask for confirmation.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only show what would be added and removed.")] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Add what is missing, step by step, then remove what is not needed.

    At a terminal and without --yes it shows the reason, the expected error and the look-alikes before each step, and
    asks: yes, another effect, details, skip or quit.

    Example: stiffcal improve demo --yes
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.improve import always, improve_campaign
        from stiffcal.workflow.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        asks = sys.stdin.isatty() and not yes and not as_json

        notify_step = None if as_json else partial(print_step, answer)
        result = improve_campaign(
            folder, context, ImproveDialog(answer.notify) if asks else always, dry_run, notify_step
        )
        after = Step.DIAGNOSE if dry_run else Step.IMPROVE
        answer.give(result, show_ladder, following(folder, store, after))
    return OK


def print_step(answer: Answer, step: ImproveStep) -> None:
    """Print a rung of the ladder as it is reached."""
    answer.notify(f"{_step_words(step)}: {deviation(step.heldout_rms)} rms in {held_out(step.scheme)}")


def _step_words(step: ImproveStep) -> str:
    return "present model" if step.action == "start" else f"{step.action} {step.effect} ({places(step.where)})"


def show_ladder(console: AnswerConsole, result: ImproveResult) -> None:
    """Draw the ladder of errors, from no model down to the noise."""
    show_verdict(console, diagnosis_level(result.adequate, bool(result.missing)), result.summary)
    console.show_warnings(result.warnings)
    show_registration(console, result.registration)
    table = plain_table("step", f"{held_out(result.steps[0].scheme)}, rms>")
    table.add_row("no model", deviation(result.steps[0].zero_model))
    for step in result.steps:
        table.add_row(_step_words(step), deviation(step.heldout_rms) if step.heldout_rms else "not done")
    table.add_row("noise", deviation(result.noise) if result.noise else NOT_KNOWN)
    console.print(table)
    changes = [step for step in result.steps if step.action in ("add", "remove")]
    for step in changes:
        done = "adding" if step.action == "add" else "removing"
        show_moved(console, step.before_after, f"what {done} {step.effect} ({places(step.where)}) changed")
    if len(changes) != 1:
        title = (
            "changes of the parameters over all steps"
            if changes
            else ("changes of the parameters if the missing effects are added")
        )
        show_moved(console, result.before_after, title)
    show_suspects(console, result.suspects, result.suspects_not_checked)
    for dependence in result.structure:
        text = f"the remaining error depends on {variable(dependence.follows)}: {dependence.seen}"
        console.print(f"  {text}", soft_wrap=True)
