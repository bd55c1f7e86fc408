"""What `improve` answers: the models step by step, each with its error in held-out data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal, TypeAlias

from stiffcal.diagnosis.answers.results import ProposedEffect, ResidualDependence
from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
from stiffcal.documents import NOT_PROMISED, CommandResult, OrAbsent
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import ModelSummary, Where
from stiffcal.reduction.registration.frames import RegistrationSummary

Action: TypeAlias = Literal["start", "add", "remove", "would add", "would remove"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImproveStep:
    """A step of `improve`: a change of the model, and the error after it."""

    action: Action
    """Start: the model as it was."""
    effect: str | None
    """What was added or removed."""
    where: Where
    """Its place."""
    heldout_rms: Rms | None
    """Of the model after it, in held-out data as ``validate`` states it; null in a dry run."""
    scheme: OrAbsent[str] = None
    """How data were left out, as in ``validate``: "leave-one-pose-out", "poses-region" of absolute poses …; None in a
    dry run.
    """
    noise: Rms | None
    """In the same measure; null where it is not known."""
    before_after: list[BeforeAfter] = field(default_factory=list)
    """What this step did to the identified values; empty for the model as it was and in a dry run."""
    probability: OrAbsent[float] = None
    """Of what was added: that it or one that looks the same was missing, as the diagnosis before it states."""
    firm: OrAbsent[bool] = None
    """Whether it was certain."""
    zero_model: Annotated[OrAbsent[Rms], NOT_PROMISED] = None
    """What a model without parameters leaves."""
    fit_id: Annotated[OrAbsent[str], NOT_PROMISED] = None
    """Of its fit in the history; None in a dry run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImproveResult(CommandResult):
    """Answer of ``improve``."""

    schema: Literal["stiffcal/improve/1"] = "stiffcal/improve/1"
    registration: OrAbsent[RegistrationSummary] = None
    """What is left between the kinematics and the places of the frames that were estimated; None where none was."""
    steps: list[ImproveStep]
    """The steps in the order in which they were taken."""
    model: ModelSummary
    """What the model holds now."""
    adequate: bool | None
    """Whether what is left is noise; null where the noise is not known."""
    unexplained: bool | None
    """Whether something is left that nothing accounts for; null where the noise is not known."""
    missing: list[ProposedEffect]
    """What was not added."""
    structure: list[ResidualDependence]
    """What the unexplained error follows, most first."""
    suspects: OrAbsent[list[Suspect]] = None
    """Runs and rows that disagree with all the others under the last model."""
    suspects_not_checked: OrAbsent[RunsNotChecked] = None
    """What was not compared with the other runs, and why, where there is anything."""
    summary: str
    """The last diagnosis in a sentence or two."""
    heldout_rms: Rms
    """Of the present model in held-out data, as ``validate`` states it."""
    noise: Rms | None
    """In the same measure; null where it is not known."""
    before_after: list[BeforeAfter] = field(default_factory=list)
    """What all steps together did to the identified values; in a dry run what they would do."""
    view: OrAbsent[str] = None
    """The page for a browser, where it was written anew."""
    report: OrAbsent[str] = None
    """The PDF, where it was written anew."""

    @property
    def changed(self) -> bool:
        """Whether model.toml was changed."""
        return any(step.action in ("add", "remove") for step in self.steps)
