"""What `improve` shows: what was gained, the ladder of models, which values each step moved, what is left."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.show import parts
from stiffcal.show.before_after import add_moved
from stiffcal.show.builder import PageBuilder
from stiffcal.show.effects import diagnosis_level
from stiffcal.show.ladder import gain_in_words, ladder
from stiffcal.wording import place, variable

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.improve_results import ImproveResult
    from stiffcal.show.options import ShowOptions


def page(result: ImproveResult, options: ShowOptions) -> Page:
    """Return the errors from no model down to the noise; of a model that was changed, how to take all steps back."""
    made = PageBuilder("The model step by step")
    if (gain := gain_in_words(result.steps)) and not result.adequate:
        # the verdict on the rest is no verdict on what was done
        made.say(gain, "gain", "pass")
    made.say(result.summary, "verdict", diagnosis_level(result))
    made.add(parts.registration(result.registration))
    made.add([ladder(result.steps, result.noise, result.steps[0].scheme)])
    changes = [step for step in result.steps if step.action in ("add", "remove")]
    for step in changes:
        done = "adding" if step.action == "add" else "removing"
        add_moved(made, step.before_after, f"what {done} {step.effect} ({place(step.where)}) changed")
    if len(changes) != 1:
        over = "over all steps" if changes else "if the missing effects are added"
        add_moved(made, result.before_after, f"changes of the parameters {over}")
    made.add(parts.suspects(result.suspects, result.suspects_not_checked, searched=True))
    texts = [f"the remaining error depends on {variable(one.follows)}: {one.seen}" for one in result.structure]
    made.list(texts, "rest")
    for written in (result.report, result.view):
        if written is not None:
            made.say(f"written anew: {written}", "written")
    if result.changed and options.folder is not None:
        undo = options.line("history", "--restore", str(result.steps[0].fit_id))
        made.say(f"changed: {options.folder / MODEL_FILE}; to undo: {undo}", "changed")
    return made.page()
