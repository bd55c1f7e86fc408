"""`stiffcal improve`: diagnose, add, identify, until nothing is missing."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.before_after import show_moved
from stiffcal.cli.endings import OK
from stiffcal.cli.improve_dialog import ImproveDialog
from stiffcal.cli.ladder_bars import WIDEST_LADDER, LiveLadder, drawn_measure, ladder_lines, rungs_of, step_words
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Overwrite, StoreAt
from stiffcal.cli.pages import draw_blocks
from stiffcal.cli.verdict import diagnosis_level, show_verdict
from stiffcal.cli.wording import deviation, places
from stiffcal.escapes.shell import command_line
from stiffcal.results.next_step import Step
from stiffcal.show import parts
from stiffcal.validation.schemes import held_out
from stiffcal.wording import listing, variable

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from stiffcal.cli.console import AnswerConsole
    from stiffcal.results.improve_results import ImproveResult, ImproveStep


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
        answer.give(result, partial(_show, folder, store), following(folder, store, after, done))
    return OK


def _show(folder: Path, store: str | None, console: AnswerConsole, result: ImproveResult) -> None:
    """Draw the ladder; of a model that was changed name the file, and the line that takes all steps back."""
    show_ladder(console, result)
    if result.changed:
        undo = command_line("history", folder, "--restore", str(result.steps[0].fit_id), store=store)
        console.print(f"changed: {folder / MODEL_FILE}; to undo: {undo}", soft_wrap=True, markup=False)


def _step_shown(answer: Answer, at_terminal: bool) -> Callable[[ImproveStep], None] | None:
    """Return what shows a step as it is reached: a ladder that grows at a terminal, else a line; None with --json."""
    if answer.as_json:
        return None
    if not (at_terminal and answer.progress.is_drawn):
        return partial(print_step, answer)
    ladder = LiveLadder()
    answer.progress.above = ladder
    return ladder.reached


def gain_in_words(steps: Sequence[ImproveStep]) -> str:
    """Return what was added and by how much the error has fallen; "" where nothing was added, or it has not."""
    first, last = steps[0], steps[-1]
    added = _still_added(steps)
    if not added or first.heldout_rms is None or last.heldout_rms is None:
        return ""
    before, after = (dict(rms.items()) for rms in (first.heldout_rms, last.heldout_rms))
    # an error may fall in one measure and rise in another: the one that is drawn decides, and those that fell are named
    fallen = [name for name, now in after.items() if now is not None and now < (before.get(name) or 0.0)]
    if drawn_measure([first.heldout_rms, last.heldout_rms]) not in fallen:
        return ""
    start, end = (deviation({name: rms[name] for name in fallen}) for rms in (before, after))
    return f"Added {listing(added)}: the error in {held_out(last.scheme)} decreased from {start} to {end} rms."


def _still_added(steps: Sequence[ImproveStep]) -> list[str]:
    """Return what was added and not taken out again, with its place."""
    added: list[str] = []
    for step in steps:
        name = f"{step.effect} ({places(step.where)})"
        if step.action == "add":
            added.append(name)
        elif step.action == "remove" and name in added:
            added.remove(name)
    return added


def print_step(answer: Answer, step: ImproveStep) -> None:
    """Print a rung of the ladder as it is reached."""
    answer.notify(f"{step_words(step)}: {deviation(step.heldout_rms)} rms in {held_out(step.scheme)}")


def show_ladder(console: AnswerConsole, result: ImproveResult) -> None:
    """Draw the ladder of errors, from no model down to the noise."""
    if (gain := gain_in_words(result.steps)) and not result.adequate:
        # the verdict on the rest is no verdict on what was done
        show_verdict(console, "pass", gain)
    show_verdict(console, diagnosis_level(result.adequate, bool(result.missing)), result.summary)
    console.show_warnings(result.warnings)
    draw_blocks(console, parts.registration(result.registration))
    scheme, width = result.steps[0].scheme, min(console.width, WIDEST_LADDER)
    for line in ladder_lines(rungs_of(result.steps, result.noise), scheme, width):
        console.print(line, no_wrap=True, overflow="ignore", crop=False)
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
    draw_blocks(console, parts.suspects(result.suspects, result.suspects_not_checked))
    for dependence in result.structure:
        text = f"the remaining error depends on {variable(dependence.follows)}: {dependence.seen}"
        console.print(f"  {text}", soft_wrap=True)
    for written in (result.report, result.view):
        if written is not None:
            console.print(f"written anew: {written}", soft_wrap=True)
