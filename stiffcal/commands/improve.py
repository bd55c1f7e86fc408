"""The loop: diagnose, add, identify, until nothing is missing; each step's fit goes into the history."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import change_model
from stiffcal.commands.validate import validate_campaign
from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect
from stiffcal.identification.answers.before_after import (
    BeforeAfter,
    EstimatedParameter,
    estimated_parameters,
    values_before_and_after,
)
from stiffcal.model.summary import EffectAt, ModelSummary, Where
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.improve_results import Action, ImproveResult, ImproveStep
from stiffcal.results.model_changes import (
    Change,
    Decision,
    EffectProposal,
    Made,
    next_changes,
    not_added_in_words,
    planned_steps,
    removed_in_words,
)
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.history import mark_likely
from stiffcal.stages.steps import RunContext, ignore_note, up_to_date_states

# More steps than six joints with five effects each: the loop ends by itself long before.
MOST_STEPS = 36

Ask = Callable[[EffectProposal], Decision]
Reached: TypeAlias = ImproveStep | DiagnoseResult
"""A step, and after those of one diagnosis the next: what is left is then known."""


def always(proposal: EffectProposal) -> Decision:
    """Agree to every change of the model."""
    return "yes"


def improve_campaign(
    folder: Path,
    context: RunContext | None = None,
    ask: Ask = always,
    dry_run: bool = False,
    notify_step: Callable[[ImproveStep], None] | None = None,
    likely: bool = False,
) -> ImproveResult:
    """Add what is missing, one effect after another, each followed by a fit and its error in held-out poses.

    Added is what is certain. Once nothing is missing, what was added and is not needed any more is removed.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    ask : asked before each change; what it skips is not proposed again.
    dry_run : only report what would be added and removed.
    notify_step : called with each step once it is validated.
    likely : whether effects that are probable and not certain are added too.

    Returns
    -------
    ImproveResult
        Each step, and what the last diagnosis found.

    Raises
    ------
    InputError : the input is wrong.
    """
    reached = improvement(folder, context or RunContext(), ask, dry_run, likely)
    while True:
        try:
            step = next(reached)
        except StopIteration as ended:
            result: ImproveResult = ended.value
            return result
        if notify_step is not None and isinstance(step, ImproveStep) and step.heldout_rms is not None:
            notify_step(step)


def improvement(
    folder: Path, context: RunContext, ask: Ask = always, dry_run: bool = False, likely: bool = False
) -> Generator[Reached, None, ImproveResult]:
    """Do as `improve_campaign`, and hand out each step once it is validated, and each diagnosis.

    If no further step is taken, model.toml stays as the last one made it.

    Yields
    ------
    ImproveStep | DiagnoseResult
        The model as it was, its diagnosis, then the steps that this calls for, the next diagnosis, and so on.

    Returns
    -------
    ImproveResult
    """
    recorder = _StepRecorder(folder, context)
    yield recorder.validate_and_add_step("start", None, Where())
    diagnosed = diagnose_campaign(folder, context)
    yield diagnosed
    if dry_run:
        recorder.steps += planned_steps(diagnosed, likely)
        yield from recorder.steps[1:]
    else:
        diagnosed = yield from _add_and_remove(recorder, diagnosed, ask, likely)
    judged = validate_campaign(folder, context)
    return ImproveResult(
        warnings=list(diagnosed.warnings),
        registration=diagnosed.registration,
        steps=recorder.steps,
        model=_present_model(folder),
        adequate=diagnosed.adequate,
        unexplained=diagnosed.unexplained,
        missing=diagnosed.missing,
        structure=diagnosed.structure,
        suspects=diagnosed.suspects,
        suspects_not_checked=diagnosed.suspects_not_checked,
        summary=diagnosed.summary
        + removed_in_words(recorder.steps)
        + ("" if likely else not_added_in_words(diagnosed)),
        heldout_rms=judged.rms,
        # the verdict's: what is missing swells the scatter of repeats about the present model
        noise=judged.noise if diagnosed.noise is None else diagnosed.noise,
        before_after=diagnosed.before_after if dry_run else recorder.before_after(),
    )


@dataclass
class _StepRecorder:
    """The steps so far, each a change of the model with the error in held-out poses after it."""

    folder: Path
    """The campaign's."""
    context: RunContext
    steps: list[ImproveStep] = field(default_factory=list)
    """The steps, first the model as it was."""
    estimates: list[list[EstimatedParameter]] = field(default_factory=list)
    """The identified values at each step."""
    added: list[Made] = field(default_factory=list)
    """What was added."""

    def validate_and_add_step(self, action: Action, effect: str | None, where: Where) -> ImproveStep:
        """Validate the present model, and append and return the step that led to it, with its error in held-out poses.

        Parameters
        ----------
        action : what was done to the model file; "start" for the model as it was.
        effect, where : what was added or removed, and its place; None and an empty place at the start.
        """
        # that an edited model is fitted anew is no news here, and the logs were looked at before
        context = self.context if action == "start" else replace(self.context, notify=ignore_note)
        judged = validate_campaign(self.folder, context)
        fit = self._present_fit()
        self.estimates.append(estimated_parameters(fit.parameters))
        step = ImproveStep(
            action=action,
            effect=effect,
            where=where,
            heldout_rms=judged.rms,
            scheme=judged.scheme,
            noise=judged.noise,
            before_after=values_before_and_after(*self.estimates[-2:]) if self.steps else [],
            zero_model=judged.zero_model,
            fit_id=fit.fit_id,
        )
        self.steps.append(step)
        return step

    def _present_fit(self) -> IdentifyResult:
        return up_to_date_fit(up_to_date_states(self.folder, self.context), self.context)

    def before_after(self) -> list[BeforeAfter]:
        """Return what all steps together did to the identified values."""
        return values_before_and_after(self.estimates[0], self.estimates[-1]) if len(self.estimates) > 1 else []

    def edit(self, change: Change, effect: ProposedEffect | EffectAt) -> ImproveStep:
        """Add or remove an effect, then validate the changed model."""
        proposed = effect if isinstance(effect, ProposedEffect) else None
        start = None if proposed is None else proposed.form
        campaign = load_campaign(Path(self.folder), check_files=False)
        change_model(campaign, change, effect.effect, where=effect.where, start=start, context=self.context)
        if change == "add":
            self.added.append((change, effect.effect, effect.where))
        step = self.validate_and_add_step(change, effect.effect, effect.where)
        if proposed is not None:
            step = self.steps[-1] = replace(step, probability=proposed.probability, firm=proposed.firm)
        if change == "add" and step.fit_id is not None and not step.firm:
            data = up_to_date_states(self.folder, self.context)
            mark_likely(data, step.fit_id, EffectAt(effect=effect.effect, where=effect.where))
        return step


def _add_and_remove(
    recorder: _StepRecorder, diagnosed: DiagnoseResult, ask: Ask, likely: bool
) -> Generator[Reached, None, DiagnoseResult]:
    """Add what is missing and remove what was added and is not needed until the model stays, or the answer is no.

    What is missing comes first: with it, other effects may turn out to be needed, or not. What is not needed is removed
    once after each addition: a diagnosis names what can go together, and one after another might take away what is
    needed in sum.

    Yields
    ------
    ImproveStep | DiagnoseResult
        As `improvement`.

    Returns
    -------
    DiagnoseResult
        The last diagnosis.
    """
    removed = False
    skipped: list[Made] = []
    for _ in range(MOST_STEPS):
        changes = next_changes(diagnosed, skipped, recorder.added, likely)
        if not changes or (removed and changes[0][0] == "remove"):
            return diagnosed
        n_before = len(recorder.steps)
        for change, effect in changes:
            decision = ask(EffectProposal(change, effect, diagnosed))
            if decision == "stop":
                return diagnose_campaign(recorder.folder, recorder.context)
            if decision == "skip":
                skipped.append((change, effect.effect, effect.where))
                continue
            yield recorder.edit(change, effect if decision == "yes" else decision)
            removed = change == "remove"
        if len(recorder.steps) > n_before:
            diagnosed = diagnose_campaign(recorder.folder, recorder.context)
            yield diagnosed
    text = f"stopped after {MOST_STEPS} steps: the model still changes; see the history"
    still = next_changes(diagnosed, skipped, recorder.added, likely)
    return replace(diagnosed, warnings=[*diagnosed.warnings, text]) if still else diagnosed


def _present_model(folder: Path) -> ModelSummary:
    from stiffcal.stages.history import model_of

    return model_of(load_campaign(Path(folder), check_files=False).model)
