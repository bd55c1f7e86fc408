"""What `diagnose` answers: whether the model is good enough, which effect it lacks, and what else was tried."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

from stiffcal.diagnosis.answers.heldout_results import ErrorAsValidated, ErrorInExperiment
from stiffcal.diagnosis.answers.pattern_results import CandidateParameter, CompliancePattern
from stiffcal.diagnosis.answers.setting_results import ContradictedSetting, WrongGeometry
from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
from stiffcal.documents import NOT_PROMISED, CommandResult, KeyIf, Number, OrAbsent, Origin
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.measurements.rms import Rms, VarianceRatio
from stiffcal.model.summary import EffectAt, Where
from stiffcal.reduction.registration.frames import RegistrationSummary


@dataclass(frozen=True, slots=True, kw_only=True)
class LookAlike(EffectAt):
    """An effect that the data cannot distinguish from the one that is named."""

    probability: OrAbsent[float] = None
    """That it is this one, given that the named effect or one that looks the same is missing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProposedEffect:
    """An effect to add."""

    effect: str
    """Its name."""
    where: Where
    """Its place."""
    alternatives: list[LookAlike]
    """Those that look the same in these poses and loads, at most four."""
    probability: OrAbsent[float] = None
    """That it or one of those that look the same is missing."""
    member_probability: OrAbsent[float] = None
    """That it is this one, given that it or one of those that look the same is missing."""
    firm: OrAbsent[bool] = None
    """Whether it is certain: both at least 0.95, also under other assumptions, and nothing is left unexplained."""
    form: OrAbsent[dict[str, float]] = None
    """Fitted values, SI, by symbol, of the form of the law that fits best, where `add` writes another by itself."""
    searched_in: OrAbsent[str] = None
    """The data that were searched separately: ``clamped-j2``, ``motion-j2`` or ``loads``. Effects of different searches
    share no parameter, and can be added in one step.
    """

    def probability_of(self, one: ProposedEffect | LookAlike) -> float | None:
        """Return the probability that it is missing itself, or one of its look-alikes; None where none is stated."""
        share = one.member_probability if isinstance(one, ProposedEffect) else one.probability
        return None if self.probability is None or share is None else self.probability * share


@dataclass(frozen=True, slots=True, kw_only=True)
class UndecidedEffect:
    """One of the effects of a group in which none has as much of the probability as the others together."""

    effect: str
    """Its name."""
    where: Where
    """Its place."""
    share: Number
    """Probability that it is this one, given that one of them is missing."""
    probability: OrAbsent[float] = None
    """The same number."""
    deciding_runs: list[str]
    """Empty: no single run decides."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """A finding in a lab engineer's words."""

    seen: str
    """What was observed, with numbers."""
    means: str
    """Which effect that is."""
    alike: str
    """What else would look the same, "" for nothing."""
    check: str
    """How to check it on the machine, "" where no check is known."""

    @property
    def text(self) -> str:
        """All of it, in one paragraph."""
        return " ".join(sentence for sentence in (self.seen, self.means, self.alike, self.check) if sentence)


@dataclass(frozen=True, slots=True, kw_only=True)
class AgreementWithPlaces:
    """What absolute poses of the reference states show of a set-up error that was fitted to displacements."""

    share: float
    """The value that places show, along the fitted one and as a share of it: 1 where they agree, 0 for nothing."""
    std: float
    """Standard uncertainty of the difference, from the geometry's tolerance and from the fit."""
    contradicted: bool
    """Whether the absolute positions contradict it: the candidate is then rejected."""
    supported: bool
    """Whether the places show it by themselves, and not something else."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A candidate for the next single step."""

    effect: str
    """Its name."""
    where: Where
    """Its place."""
    verdict: Literal["supported", "possible", "rejected"]
    """Possible: supported too, but another ranks higher, or not to be distinguished from the one that is supported."""
    explains: Number
    """Share of the avoidable error that goes with it: (before² − after²) / (before² − noise²), whitened, by one linear
    step; null where the error is no more than noise. Above 1 where less than the noise is left, below 0 where the error
    rises; the terminal and the report print 0 to 100 %.
    """
    size_m: Number
    """m, rms of what it adds at the tool; null for effects of moving joints."""
    size_Nm: OrAbsent[float] = None
    """N·m, rms of what it adds to a drive's torque; of effects of moving joints."""
    p_value: Number
    """Probability of so large a fall of the error by chance, all candidates counted."""
    heldout_rms_before: Rms
    """In held-out poses, as ``rms`` of the diagnosis, without it."""
    heldout_rms_after: Rms
    """In held-out poses, with it."""
    heldout_rms_after_choosing: Rms | None
    """The same with the choice itself repeated without each pose; of the first alone."""
    confidence: Number
    """Null: no choice is repeated."""
    probability: OrAbsent[float] = None
    """That it is there; None where nothing could be judged."""
    parameters: list[CandidateParameter]
    """First estimates, from one linear step with it; `before_after` has the refitted values of what is missing."""
    alternatives: list[EffectAt]
    """Those that look the same in these poses and loads."""
    places: AgreementWithPlaces | None = None
    """What absolute poses show of it; null where they cannot show it."""
    by_experiment: OrAbsent[list[ErrorInExperiment]] = None
    """The same errors by kind of experiment, where the campaign holds several; None where it holds one."""
    why: str = ""
    """The verdict's reason, in words."""
    evidence: Annotated[Explanation | None, NOT_PROMISED] = None
    """The same in parts; null for what is rejected."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LawCurveAt:
    """By how much a joint gives by a law, beyond all else that is in the model, over what it follows."""

    over: str
    """``torque:4`` or ``angle:2``, as ``plot --against`` takes it."""
    unit: str
    """Of ``at``: N*m, N, rad or m."""
    value_unit: str
    """Of ``value``: rad or m, or that over the drive's own load where the law is one of compliance."""
    at: list[float]
    """Ascending; each point is a mean over as many load states."""
    value: list[float]
    """There."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownLaw:
    """A law that is none of the catalogue's effects, and is probably missing."""

    follows: str
    """What it follows."""
    where: Where
    """The joint or link at which it acts; empty for the set-up."""
    of: str
    """The same in words."""
    probability: float
    """That it is there."""
    curve: LawCurveAt | None
    """The law itself, at its best values; null of what follows several variables at once, and of moving joints."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExcludedSizeAt:
    """How large something at a place would have been found in nine campaigns of ten like this one."""

    where: Where
    """The joint or link; empty for the set-up."""
    of: str
    """The same in words."""
    size_m: Number
    """m, rms of the tool's displacement by it; null where nothing there shows in these poses and loads, and of moving
    joints.
    """
    size_Nm: OrAbsent[Number] = None
    """N·m, rms of what it adds to a drive's torque; of moving joints."""
    effect: str
    """The effect there that shows least."""
    deciding_force_N: OrAbsent[float] = None
    """N, largest force with which, in poses like these, it would be found where it is as large as the noise under the
    present loads; no key where it is found with these, where no load makes it larger, where the noise is not known, and
    of moving joints.
    """


@dataclass(frozen=True, slots=True)
class UntestableEffect:
    """An effect that these data cannot show."""

    effect: str
    """Its name."""
    needs: str
    """What it would take."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualDependence:
    """Something that the unexplained error follows."""

    follows: str
    """"joint angle", "load", "branch", "time", "temperature" or "approach" (the directions in which the joints moved
    last); of moving joints also "time in the run", "position" or "speed".
    """
    share: Number
    """Of the avoidable squares."""
    seen: str
    """How it follows, in words."""
    in_resamplings: OrAbsent[float] = None
    """Share of resamplings of whole speeds or seconds of motion in which the error left out falls with a curve over it;
    of moving joints alone.
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparatingMeasurement:
    """A pose and a load in which two look-alikes differ."""

    pose_deg: list[float]
    """Of the logged joints, degrees; of prismatic joints mm."""
    load: list[float]
    """Force and moment in the sensor's axes, N and N·m."""
    separates: list[EffectAt]
    """The two."""
    gain: Number
    """What a refit of either model to all data and this load leaves of the difference, over the noise; null where the
    noise is not known.
    """
    difference_m: float
    """m, of the two predictions at the tool."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchPace:
    """How much was tried, and how fast."""

    models: int
    """To how many models the catalogue was added."""
    candidates: int
    """Effects at places, all models together."""
    signatures: int
    """The same with every shape."""
    seconds: float
    """Spent on them, the models' own fits not counted."""
    candidates_per_second: float
    """`candidates` over `seconds`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunErrors:
    """A run's error in poses left out, without an effect and with it."""

    label: str
    """The run."""
    before: float
    """m or rad, without."""
    after: float
    """m or rad, with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectEvidenceSummary:
    """The evidence for an effect; its load states are the table ``evidence``."""

    effect: str
    """Its name."""
    where: Where
    """Its place."""
    status: Literal["missing", "in the model"]
    driver: str
    """What the residual is drawn against."""
    unit: str
    """Of the covariate, "1" for a number."""
    component: Literal["translation", "rotation", "length", "motor_angle"]
    """Which residual is drawn: m or rad; "length" are rods, "motor_angle" clamped motors."""
    lever: Number
    """m or 1, mean lever that turns were multiplied with; null where the residual itself is projected."""
    heldout_rms_before: Rms
    """Of the whole residual in held-out poses, without it."""
    heldout_rms_after: Rms
    """Of the whole residual in held-out poses, with it."""
    by_run: list[RunErrors]
    """Of the residual that is drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WithSuspects:
    """What the answer is where the runs that disagree with all the others are kept."""

    missing: list[ProposedEffect]
    """Effects to add, in order."""
    unexplained: bool | None
    """Whether something is left that nothing accounts for; null where the noise is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnoseResult(CommandResult):
    """Answer of ``diagnose``."""

    schema: Literal["stiffcal/diagnose/1"] = "stiffcal/diagnose/1"
    registration: OrAbsent[RegistrationSummary] = None
    """What is left between the kinematics and the places of the frames that were estimated; None where none was."""
    adequate: bool | None
    """Whether what is left is noise; null where the noise is not known."""
    noise: Rms | None
    """In the same measure; null where it is not known."""
    rms: Rms
    """Of the present model in held-out poses: each pose left out in turn (all runs or rows whose joints agree within
    1°), as for every ``heldout_rms_…`` of this document. Of moving joints each speed or second, of clamped runs each
    position or cycle.
    """
    as_validated: OrAbsent[ErrorAsValidated] = None
    """The same by the scheme of ``validate``, ``improve`` and ``history``, where that is another: regions left out of
    absolute poses, or runs kept back.
    """
    lack_of_fit: VarianceRatio | None
    """What is left against what repeats scatter."""
    missing: list[ProposedEffect]
    """Effects to add, in order."""
    p_nothing: OrAbsent[float] = None
    """Probability that nothing is missing that shows more than half of the noise; None where nothing could
    be judged.
    """
    p_unknown: OrAbsent[float] = None
    """Probability that something is missing that is none of the catalogue's effects; None where nothing could be
    judged.
    """
    unknown: OrAbsent[list[UnknownLaw]] = None
    """Laws that nobody has written down, most probable first."""
    not_weighed: OrAbsent[float] = None
    """Share of all probability that combinations which were not compared have, as far as single effects gain next to
    those that were; None where nothing could be judged.
    """
    excluded_sizes: OrAbsent[list[ExcludedSizeAt]] = None
    """What could not be excluded, place by place, where nothing is found."""
    in_model: OrAbsent[list[ProposedEffect]] = None
    """Effects that the model holds beyond its springs, each with its probability and those that look the same."""
    contradicted: Annotated[list[ContradictedSetting], NOT_PROMISED] = field(default_factory=list)
    """What model.toml sets and the data contradict; ``missing`` is the answer without these settings."""
    undecided: list[UndecidedEffect] = field(default_factory=list)
    """Effects of which one is missing and none is as probable as the others together, the most probable first: at most
    four.
    """
    could_be: list[EffectAt]
    """Effects of which each alone fits all poses, with all its places, where the poses are too few to decide which."""
    findings: list[Finding]
    """All candidates for the next single step, best first."""
    next_measurement: SeparatingMeasurement | None
    """What would separate the first missing effect from a look-alike."""
    not_tried: list[UntestableEffect]
    unexplained: bool | None
    """Whether something is left that nothing accounts for; null where neither noise nor structure is known."""
    structure: list[ResidualDependence]
    """What the unexplained error follows, most first."""
    wrong_geometry: Annotated[OrAbsent[WrongGeometry], NOT_PROMISED] = None
    """Where absolute poses contradict the robot file: nothing is named that its errors explain."""
    pattern: Annotated[CompliancePattern | None, NOT_PROMISED] = None
    """Whose compliance varies with what, where something is left that nothing accounts for; null where none does."""
    explained_by_missing: Annotated[Number, KeyIf("has_searched"), NOT_PROMISED] = None
    """Share of the avoidable error that goes with what is missing; of all of it where the noise is not known."""
    explained_interval: Annotated[list[float] | None, NOT_PROMISED] = None
    """Of that share, 95 % limits over poses; null where nothing is missing."""
    heldout_rms_with_missing: Annotated[OrAbsent[Rms], NOT_PROMISED] = None
    """In held-out poses, as ``rms``, with what is missing."""
    heldout_rms_after_choosing: Rms
    """In held-out poses, the choice of the first effect repeated without each pose."""
    parameters_with_missing: Annotated[list[IdentifiedParameter], NOT_PROMISED]
    """Of the model with what is missing, as in ``identify``."""
    before_after: list[BeforeAfter] = field(default_factory=list)
    """What adding all that is missing does to the identified values, all of them refitted; the missing effects' own
    parameters among them, without a value before.
    """
    n_candidates: Annotated[OrAbsent[int], NOT_PROMISED] = None
    """Effects at places that were tried for the next step."""
    n_signatures: Annotated[OrAbsent[int], NOT_PROMISED] = None
    """The same with every shape."""
    pace: SearchPace
    summary: str
    """The answer in a sentence or two."""
    superfluous: Annotated[list[EffectAt], NOT_PROMISED]
    """Effects of the model without which the error is no larger."""
    evidence: Annotated[list[EffectEvidenceSummary], NOT_PROMISED]
    """The evidence for what is missing, and for what the model holds beyond the joints' compliances."""
    suspects: OrAbsent[list[Suspect]] = None
    """Runs and rows that disagree with all the others; the answer is without them, except for steps inside a run."""
    suspects_not_checked: OrAbsent[RunsNotChecked] = None
    """What was not compared with the other runs, and why, where there is anything."""
    with_suspects: OrAbsent[WithSuspects] = None
    """The answer with them, where there are any."""
    fit_id: Annotated[str, NOT_PROMISED]
    """The fit that was diagnosed."""
    key: Annotated[str, NOT_PROMISED]
    """A hash of all that went into it."""
    origin: OrAbsent[Origin] = None
    """From whom it comes."""

    @property
    def has_searched(self) -> bool:
        """Whether there were load states to search."""
        return self.n_candidates is not None

    def finding_of(self, effect: EffectAt | ProposedEffect | EffectEvidenceSummary) -> Finding | None:
        """Return the finding of an effect at its place, None where it was not tried."""
        return finding_of(self.findings, effect)

    def explained_by(self, finding: Finding) -> float | None:
        """Return the share of the avoidable error that a candidate explains; as refitted where it alone is missing."""
        alone = self.missing[0] if len(self.missing) == 1 else None
        if alone is not None and (finding.effect, finding.where) == (alone.effect, alone.where):
            return finding.explains if self.explained_by_missing is None else self.explained_by_missing
        return finding.explains


@dataclass(frozen=True, slots=True, kw_only=True)
class EarlierDiagnosis:
    """What the store keeps of a diagnosis that a later one has replaced."""

    fit_id: str
    """The fit that was diagnosed."""
    summary: str
    """The answer in a sentence or two."""
    missing: list[ProposedEffect]
    next_measurement: SeparatingMeasurement | None = None
    rms: Rms
    """Of that model in held-out poses."""
    noise: Rms | None
    heldout_rms_with_missing: Rms | None = None
    """In held-out poses, with what was missing."""
    states_key: str
    """A hash of the load states."""
    findings: list[Finding]
    """The first few."""
    origin: OrAbsent[Origin] = None
    """From whom it comes."""

    def finding_of(self, effect: EffectAt | ProposedEffect | EffectEvidenceSummary) -> Finding | None:
        """Return the finding of an effect at its place, None where it is not among the first."""
        return finding_of(self.findings, effect)


def supported_but_not_named(diagnosis: DiagnoseResult) -> Finding | None:
    """Return the first finding where it is significant and the answer still names no effect, else None."""
    leading = next(iter(diagnosis.findings), None)
    named = diagnosis.missing or diagnosis.undecided or diagnosis.could_be
    if leading is None or leading.verdict != "supported" or named or not diagnosis.unexplained:
        return None
    return leading


def finding_of(
    findings: Sequence[Finding], effect: EffectAt | ProposedEffect | EffectEvidenceSummary
) -> Finding | None:
    """Return the finding of an effect at its place, None where there is none."""
    for finding in findings:
        if finding.effect == effect.effect and finding.where == effect.where:
            return finding
    return None
