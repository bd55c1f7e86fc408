"""Findings in a lab engineer's words: what was observed, how large at the tool, what it means, how to check it."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.diagnosis.answers.heldout_results import ErrorInExperiment
from stiffcal.diagnosis.answers.pattern_results import CompliancePattern, FollowedBy, PatternAlternative
from stiffcal.diagnosis.answers.results import AgreementWithPlaces, Explanation
from stiffcal.diagnosis.refits.heldout_error import errors_by_experiment, poses_helped, size_at_tool
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.lack_of_fit import fitted_values
from stiffcal.diagnosis.scans.load_scan import LoadScan
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.identification.readings.state_kinds import StateKind, measured_kinds
from stiffcal.measurements.rms import Rms
from stiffcal.model.effect import Place
from stiffcal.model.summary import EffectAt
from stiffcal.quantity import of_measure, quantity_of
from stiffcal.wording import in_unit, length, percent, place

PLACE_WORDS = {"joints": "joint", "links": "link", "pairs": "joints"}


def place_in_words(place: Place) -> str:
    """Return the place in words.

    Examples
    --------
    >>> place_in_words(Place("pairs", (5, 6)))
    'joints 5 and 6'
    >>> place_in_words(Place("joints", (1, 2, 3)))
    'joints 1, 2 and 3'
    """
    if place.kind == "setup":
        return "the set-up"
    if place.kind == "links":
        return f'link "{place.link}"'
    *others, last = map(str, place.joints)
    several = "s" if others and place.kind == "joints" else ""
    return f"{PLACE_WORDS[place.kind]}{several} {' and '.join((', '.join(others), last)) if others else last}"


def what_is_followed(pattern: CompliancePattern | PatternAlternative) -> str:
    """Return what a joint's compliance follows."""
    return {
        FollowedBy.JOINT_ANGLE: f"angle of joint {pattern.of_joint}",
        FollowedBy.JOINT_TORQUE: f"size of the torque on joint {pattern.of_joint}",
        FollowedBy.LOAD: "size of the load",
        FollowedBy.TIME: "time",
        FollowedBy.LAST_MOTION: f"last motion of joint {pattern.of_joint}, with its torque or against it",
    }[pattern.follows]


def suggested_name(pattern: CompliancePattern) -> str:
    """Return a name for the effect that tests a pattern."""
    words = {
        FollowedBy.JOINT_ANGLE: f"angle-{pattern.of_joint}",
        FollowedBy.JOINT_TORQUE: f"torque-{pattern.of_joint}",
        FollowedBy.LOAD: "load",
        FollowedBy.TIME: "time",
        FollowedBy.LAST_MOTION: f"last-motion-{pattern.of_joint}",
    }
    return f"compliance-over-{words[pattern.follows]}"


def pattern_in_words(pattern: CompliancePattern | PatternAlternative) -> str:
    """Return which joint's compliance follows what, and the share of the error that it explains."""
    share = f"{percent(pattern.share)} of the remaining error"
    return f"the compliance of joint {pattern.joint} depends on the {what_is_followed(pattern)} ({share})"


def candidate_in_words(candidate: Candidate) -> str:
    """Return effect and place in words."""
    if candidate.place.kind == "setup":
        return candidate.effect.name
    return f"{candidate.effect.name} of {place_in_words(candidate.place)}"


def effect_in_words(effect: EffectAt) -> str:
    """Return an effect of a result and its place in words.

    Examples
    --------
    >>> from stiffcal.model.summary import Where
    >>> effect_in_words(EffectAt(effect="link-geometry", where=Where(joints=[1])))
    'link-geometry of joint 1'
    """
    places = {kind: items for kind, items in effect.where.items() if items}
    return f"{effect.effect} of {place(places)}" if places else effect.effect


def places_in_words(places: AgreementWithPlaces) -> str:
    """Return how much of a set-up error absolute poses show."""
    share, limit = 100.0 * places.share, 200.0 * places.std
    return f"which show {share:.0f} ± {limit:.0f} % of the fitted value in the unloaded poses"


def error_in_words(value: float, measure: str) -> str:
    """Return an error with its unit.

    Parameters
    ----------
    value : m, rad or N·m. measure : "translation", "motor_angle" or "torque".
    """
    return in_unit(value, of_measure(measure).usual)


def leading_measure(rms: Rms) -> str:
    """Return the measure by which an error is named: the tool's place, else the motors' angles, else the torque."""
    known = {name for name, value in rms.items() if value is not None}
    return next((name for name in ("translation", "motor_angle", "torque") if name in known), "translation")


def explain(scan: LoadScan, trial: Trial, before: Rms, after: Rms, alike: Sequence[Candidate]) -> Explanation:
    """Explain a candidate.

    Parameters
    ----------
    scan, trial : the scan and the candidate.
    before, after : rms in held-out poses without and with it.
    alike : look-alikes.
    """
    effect, place = trial.candidate.effect, trial.candidate.place
    helped, poses = poses_helped(scan, trial), len(scan.folds)
    effect_text = f"At {place_in_words(place)}: {effect.fingerprint or effect.summary}"
    measure = leading_measure(before)
    if measure == "translation":
        effect_text += f", by {length(size_at_tool(scan, trial), digits=2)} rms at the tool"
    kinds = errors_by_experiment(scan, trial)
    errors = [dict(rms.items()).get(measure) for rms in (before, after)]
    if kinds:
        by_name = {kind.name: kind for kind, _ in measured_kinds(scan.fit.data)}
        parts = [_in_experiment(by_name[error.experiment], error) for error in kinds]
        effect_text += f"; with it the error decreases {' and '.join(parts)}."
    elif errors[0] is not None and errors[1] is not None:
        first, last = (error_in_words(error or 0.0, measure) for error in errors)
        effect_text += f"; with it the error in held-out poses decreases from {first} to {last}"
    if not kinds:
        effect_text += f", in {helped} of {poses} poses."
    means = f"That is {effect.name}: {effect.summary}{values_in_words(trial, _logs_temperature(scan))}."
    if trial.places is not None and trial.places.supported:
        means += f" Absolute positions support it, {places_in_words(trial.places)}."
    look_alike_text = ""
    if alike:
        names = [candidate_in_words(candidate) for candidate in alike]
        listed = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
        look_alike_text = f"In these poses and loads {listed} cannot be distinguished from it."
    check = f"To check on the machine: {effect.how_to_check}" if effect.how_to_check else ""
    return Explanation(seen=effect_text, means=means, alike=look_alike_text, check=check)


def _logs_temperature(scan: LoadScan) -> bool:
    return scan.fit.data.order.logs_temperature


def _in_experiment(kind: StateKind, error: ErrorInExperiment) -> str:
    """Return what an effect does to the held-out error of one kind of experiment, in words."""
    text = f"in {error.n_fell} of {error.n_folds} held-out {kind.left_out}"
    if error.before is None or error.after is None:
        return text
    first, last = error_in_words(error.before, kind.measure), error_in_words(error.after, kind.measure)
    return f"{text} (from {first} to {last})"


def values_in_words(trial: Trial, by_temperature: bool = False) -> str:
    """Return a candidate's values before all parameters are refitted, in brackets; "" where all are nothing.

    Parameters
    ----------
    trial : the candidate. by_temperature : whether a drift follows a temperature; else it follows the time.
    """
    texts = []
    for symbol, value in fitted_values(trial).items():
        spec = trial.candidate.effect.spec(symbol)
        if value != 0.0:
            quantity = quantity_of(spec.unit, "temperature" if by_temperature else "time")
            texts.append(f"{symbol} {in_unit(value, quantity.unit_for([value]))}")
    return f" (first estimate, before the refit: {', '.join(texts[:6])})" if texts else ""
