"""What ``validate`` answers: the error in poses that the fit left out, and whether the thresholds hold."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
from stiffcal.documents import NOT_PROMISED, CommandResult, KeyIf, ManyKeys, OrAbsent, Origin
from stiffcal.kinds import section_types
from stiffcal.kinds.results import HeldoutSection
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import ModelSummary
from stiffcal.reduction.registration.frames import RegistrationSummary
from stiffcal.validation.distance_results import Distances, LadderStep
from stiffcal.validation.elasticity_results import Elasticity
from stiffcal.validation.results import ErrorSlice, ThresholdCheck, Verdict, WorstState


def heldout_types() -> dict[str, type[HeldoutSection]]:
    """Return the types of the sections that kinds of experiment add, by the kind's name."""
    return dict.fromkeys(section_types(), HeldoutSection)


NEARLY_ALIKE = 1.15
"""Largest error over the least one below which errors of parts are stated as one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ValidateResult(CommandResult):
    """Answer of ``validate``."""

    schema: Literal["stiffcal/validate/1"] = "stiffcal/validate/1"
    registration: OrAbsent[RegistrationSummary] = None
    """What is left between the kinematics and the places of the frames that were estimated; None where none was."""
    scheme: str
    """How data were left out: "leave-one-pose-out" (each pose in turn: all runs or rows whose joints agree within 1°),
    "poses-region" (of absolute poses, each of six regions of the joints' ranges), "holdout" (the runs kept back),
    "none" (a single pose), or words of another kind of experiment; several are separated by "; ".
    """
    n_states: Annotated[int, NOT_PROMISED]
    """Load states that were judged."""
    n_poses: Annotated[int, NOT_PROMISED]
    """Parts that were left out one after another."""
    rms: Rms
    """Of the residual."""
    max: Rms
    """The largest residual, in the same measures."""
    noise: Rms | None
    """What the instruments scatter, in the same measures; None where it is not known."""
    relative: Rms
    """Residual over what was measured, a share in each measure."""
    zero_model: Rms
    """What a model without parameters leaves."""
    by_run: list[ErrorSlice]
    by_direction: list[ErrorSlice]
    """By the base axis that the load points along most."""
    by_load: list[ErrorSlice]
    """By the size of the load, N."""
    by_branch: list[ErrorSlice]
    """By the branch of the load cycle."""
    by_joint_angle: list[ErrorSlice]
    """By the angle of each joint, rad."""
    by_body: OrAbsent[list[ErrorSlice]] = None
    """By the tracked body, where there are several."""
    by_experiment: OrAbsent[list[ErrorSlice]] = None
    """By the kind of experiment ("loads", "clamped", "absolute"), where several are fitted together."""
    distance: OrAbsent[Distances] = None
    """How far predicted and measured places are apart; None where no run is absolute."""
    ladder: OrAbsent[list[LadderStep]] = None
    """From the nominal robot to the present model; None where no run is absolute."""
    elasticity: OrAbsent[Elasticity] = None
    """Whether places show that the joints give; None where no run is absolute."""
    worst: list[WorstState]
    """The states with the largest residuals, worst first."""
    by_joint: OrAbsent[list[ErrorSlice]] = None
    """By the joint, of other experiments."""
    sections: Annotated[dict[str, HeldoutSection], ManyKeys(heldout_types)] = field(default_factory=dict)
    """What kinds of experiment add, by the kind's name."""
    suspects: OrAbsent[list[Suspect]] = None
    """Runs and states that disagree with all the others; None where there are no load states."""
    suspects_not_checked: OrAbsent[RunsNotChecked] = None
    """What was not compared with the other runs, and why, where there is anything."""
    fit_id: Annotated[str | None, KeyIf("", null=False), NOT_PROMISED] = None
    """Number of the fit in the history; None where another campaign's model was judged."""
    key: Annotated[str | None, KeyIf("", null=False), NOT_PROMISED] = None
    """A hash of all that went into the result; None where it is not stored."""
    passed: bool = False
    """Whether no threshold fails; False before they are judged."""
    failed: list[str] = field(default_factory=list)
    """Thresholds that do not hold, in words."""
    not_judged: list[str] = field(default_factory=list)
    """Thresholds that cannot be judged, in words."""
    checks: list[ThresholdCheck] = field(default_factory=list)
    """Every threshold, judged."""
    thresholds: Annotated[dict[str, object], NOT_PROMISED] = field(default_factory=dict)
    """What was asked for, as campaign.toml writes it."""
    model_of: Annotated[str | None, KeyIf("", null=False), NOT_PROMISED] = None
    """Folder of the campaign whose model was judged; None where it is the present one."""
    model: Annotated[ModelSummary | None, KeyIf("", null=False), NOT_PROMISED] = None
    """That model."""
    origin: OrAbsent[Origin] = None
    """From whom the result comes."""

    def section(self, kind: str) -> HeldoutSection | None:
        """Return the section of a kind of experiment, by the kind's name; None where there is none."""
        return self.sections.get(kind)

    def judged(self, verdict: Verdict) -> ValidateResult:
        """Return the same errors with what came of the thresholds."""
        return replace(
            self,
            passed=verdict.passed,
            failed=verdict.failed,
            not_judged=verdict.not_judged,
            checks=verdict.checks,
            thresholds=verdict.thresholds,
        )
