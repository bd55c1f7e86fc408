"""The steps of `improve`, one after another, as a notebook takes them."""

from __future__ import annotations

import html
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.measurements.rms import Rms
from stiffcal.report.wording import measure_text
from stiffcal.results.improve_results import ImproveResult, ImproveStep
from stiffcal.validation.schemes import held_out
from stiffcal.wording import place_label

if TYPE_CHECKING:
    from stiffcal.commands.improve import Reached
    from stiffcal.documents import Document
    from stiffcal.model.summary import EffectAt

Verdict = Literal["adequate", "missing", "undecided", "unexplained", "not judged"]


@dataclass(frozen=True)
class ImprovementStep:
    """A change of the model, and what it did.

    Errors are rms lengths in held-out data as ``validate`` states them, SI; None where they are not known.
    """

    step: ImproveStep
    """The same as in the JSON document of ``improve``."""
    error_before: Rms | None
    """Before the change; None for the model as it was."""
    verdict: Verdict
    """What the diagnosis says of the model after it: "adequate" (what is left is noise), "missing" (an effect is),
    "undecided" (between several), "unexplained" (by any effect); "not judged" where the noise is not known, in a dry
    run, and of a step that others follow before the next diagnosis.
    """
    missing: tuple[EffectAt, ...] = ()
    """What is missing then."""
    summary: str = ""
    """The diagnosis in a sentence or two."""

    @property
    def action(self) -> str:
        """What was done: "start" (the model as it was), "add", "remove"; in a dry run "would add", "would remove"."""
        return self.step.action

    @property
    def effect(self) -> str | None:
        """What was added or removed."""
        return self.step.effect

    @property
    def place(self) -> str:
        """Where, as in names of parameters: ``j4``; "" of the set-up and of the model as it was."""
        return place_label(self.step.where) if any(self.step.where.items()) else ""

    @property
    def error(self) -> Rms | None:
        """After the change."""
        return self.step.heldout_rms

    @property
    def noise(self) -> Rms | None:
        """The error that is left when nothing is missing, in the same measure."""
        return self.step.noise

    def __str__(self) -> str:
        error = "not done" if self.error is None else measure_text(self.error)
        before = "" if self.error_before is None else f"{measure_text(self.error_before)} → "
        noise = "not known" if self.noise is None else measure_text(self.noise)
        in_what = "" if self.error is None else f" in {held_out(self.step.scheme)}, noise {noise}"
        return f"{self._name}: {before}{error}{in_what}"

    @property
    def _name(self) -> str:
        if self.effect is None:
            return "present model"
        return f"{self.action} {self.effect} {self.place}".rstrip()

    def _repr_html_(self) -> str:
        says = f"<div>{html.escape(self.summary)}</div>" if self.summary else ""
        return f"<div><b>{html.escape(str(self))}</b></div>{says}"


class ModelImprovement(Iterator[ImprovementStep]):
    """The steps of ``improve``; each is taken when it is asked for.

    Parameters
    ----------
    reached : of `stiffcal.commands.improve.improvement`.
    logged : has what the command line would write to standard error go to the logger.
    """

    def __init__(
        self, reached: Generator[Reached, None, ImproveResult], logged: Callable[[], AbstractContextManager[None]]
    ) -> None:
        self._reached, self._logged = reached, logged
        self._ahead: Reached | None = None
        self._result: ImproveResult | None = None
        self.steps: list[ImprovementStep] = []
        """Those that were taken."""

    def __next__(self) -> ImprovementStep:
        """Take the next step: change the model, fit it, judge and diagnose it.

        Raises
        ------
        InputError : the input is wrong.
        """
        with self._logged():
            first, then = self._ahead or self._take(), None
            self._ahead = None
            if isinstance(first, DiagnoseResult):  # of a step that was skipped: nothing was changed
                first = self._take()
            if first is None or isinstance(first, DiagnoseResult):
                raise StopIteration
            then = self._take()
        if not isinstance(then, DiagnoseResult):
            self._ahead, then = then, None
        step = self._step(first, then)
        self.steps.append(step)
        return step

    def _take(self) -> Reached | None:
        try:
            return next(self._reached)
        except StopIteration as ended:
            self._result = ended.value or self._result
            return None

    def _step(self, step: ImproveStep, diagnosis: DiagnoseResult | None) -> ImprovementStep:
        before = self.steps[-1].error if self.steps else None
        if diagnosis is None:
            return ImprovementStep(step, before, "not judged")
        return ImprovementStep(step, before, _verdict(diagnosis), _effects(diagnosis), diagnosis.summary)

    @property
    def result(self) -> ImproveResult:
        """What ``improve`` answers; the steps that are left are taken first.

        Raises
        ------
        InputError : the input is wrong.
        RuntimeError : an error or an interruption has ended the steps before.
        """
        for _ in self:
            pass
        if self._result is None:
            raise RuntimeError("the steps ended before their time: begin again with improve()")
        return self._result

    def to_dict(self) -> Document:
        """Return the document that ``stiffcal improve --json`` prints; the steps that are left are taken first."""
        return self.result.to_document()

    def __repr__(self) -> str:
        if not self.steps:
            return "<no step of improve is taken yet: for step in …, or .result for all>"
        return "\n".join(map(str, self.steps))

    def _repr_html_(self) -> str:
        from stiffcal.python.notebook import html_of
        from stiffcal.show.builder import PageBuilder
        from stiffcal.show.ladder import ladder
        from stiffcal.show.pages import page_of

        if self._result is not None:
            return html_of(page_of(self._result), self._result.warnings)
        made = PageBuilder("The model step by step")
        if not self.steps:
            made.say(repr(self), "not-begun")
            return html_of(made.page())
        last = self.steps[-1]
        made.add([ladder([step.step for step in self.steps], last.noise, last.step.scheme)])
        made.say(last.summary, "verdict")
        return html_of(made.page())


def _verdict(diagnosis: DiagnoseResult) -> Verdict:
    if diagnosis.missing:
        return "missing"
    if diagnosis.undecided or diagnosis.could_be:
        return "undecided"
    if diagnosis.adequate:
        return "adequate"
    return "not judged" if diagnosis.adequate is None else "unexplained"


def _effects(diagnosis: DiagnoseResult) -> tuple[EffectAt, ...]:
    from stiffcal.model.summary import EffectAt

    return tuple(EffectAt(effect=effect.effect, where=effect.where) for effect in diagnosis.missing)
