"""The last line of an answer: the step that `stiffcal.results.next_step` decides on, as a command to copy."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from stiffcal.escapes.shell import command_line, escaped_path
from stiffcal.presentation.values import NextStep
from stiffcal.results.next_step import Standing, Step, next_step

if TYPE_CHECKING:
    from pathlib import Path

    from stiffcal.ingest.checks.results import CheckResult

NO_EFFECT = "an effect is in the model (stiffcal add DIR EFFECT --all)"
LATER = "there is a later campaign of this robot"


def following(folder: Path, store: str | None, after: Step | None = None, done: Collection[Step] = ()) -> NextStep:
    """Return the line that follows an answer about a campaign.

    Parameters
    ----------
    folder : the campaign folder. store : where results are kept; None: in the folder.
    after : the step that has answered; None of a command that is no step of the loop.
    done : steps whose files that command has written too.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    from stiffcal.commands.standing import standing_of
    from stiffcal.stages.steps import RunContext

    return line_of(folder, standing_of(folder, RunContext(store=store, update=False)), store, after, done)


def line_of(
    folder: Path, standing: Standing, store: str | None, after: Step | None = None, done: Collection[Step] = ()
) -> NextStep:
    """Return the line that follows, of a campaign of which so much is known; arguments as in `following`."""
    step = next_step(standing, after, done)
    if step is None:
        return _with_a_later_one(folder)
    if step is Step.EXPORT:
        return NextStep(command_line("export", folder, "-o", "model.json", store=store))
    if step is Step.NEW_EFFECT:
        return NextStep(f"stiffcal effects new {standing.untested} --from {escaped_path(str(folder))}")
    missing = step is Step.IDENTIFY and not standing.has_effects
    return NextStep(command_line(step.value, folder, store=store), once=NO_EFFECT if missing else "")


def _with_a_later_one(folder: Path) -> NextStep:
    """Return the comparison with a later campaign; each keeps its results in its own folder."""
    return NextStep(command_line("compare", folder, "LATER_DIR"), once=LATER)


def after_check(folder: Path, result: CheckResult, store: str | None) -> NextStep:
    """Return `run` of a campaign that is ready, `plan` where joints lack load; else what is listed comes first.

    Parameters
    ----------
    folder : the campaign folder. result : of `check`. store : where results are kept; None: in the folder.
    """
    if result.ready:
        from stiffcal.commands.standing import has_effects

        return NextStep(command_line("run", folder, store=store), once="" if has_effects(folder) else NO_EFFECT)
    from stiffcal.show.answers.check import lacks_load

    if not lacks_load(result):
        return NextStep(command_line("check", folder, store=store), once="that is done")
    from stiffcal.stages.plans.plannable import plannable_words
    from stiffcal.stages.steps import RunContext

    force = max((run.largest_force_N or 0.0 for run in result.runs), default=0.0)
    words = plannable_words(folder, force, RunContext(store=store))
    return NextStep(command_line("run" if words is None else "plan", folder, *(words or ()), store=store))


def after_export(folder: Path, store: str | None) -> NextStep:
    """Return what the model serves for later: the comparison with another campaign; without a fit, predictions.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    from stiffcal.commands.history import read_history
    from stiffcal.stages.steps import RunContext

    if read_history(folder, RunContext(store=store, update=False)).fits:
        return _with_a_later_one(folder)
    poses = "poses.csv"  # the values are those of model.toml
    line = command_line("predict", folder, "--poses", poses, store=store)
    return NextStep(line, once=f"poses and loads are in {poses}")


def after_trust(folder: Path, store: str | None) -> NextStep:
    """Return the step of a folder whose code may run now; `check` where it holds no campaign that can be read."""
    from stiffcal.errors import InputError

    try:
        return following(folder, store)
    except InputError:
        return NextStep(command_line("check", folder, store=store))


def to_begin(folder: Path, store: str | None = None) -> NextStep:
    """Return `run` of a campaign whose logs are all there, else `check`, which names what is missing or wrong."""
    from stiffcal.commands.standing import logs_complete
    from stiffcal.errors import InputError

    try:
        complete = logs_complete(folder)
    except InputError:
        complete = False
    return NextStep(command_line("run" if complete else "check", folder, store=store))
