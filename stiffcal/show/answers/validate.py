"""What `validate` shows: the error in held-out data next to the noise, where it is largest, what does not hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.presentation.values import Sentence
from stiffcal.quantity import LENGTH, Units
from stiffcal.results.model_words import STEPS
from stiffcal.results.next_step import is_within_noise
from stiffcal.show import parts
from stiffcal.show.builder import PageBuilder, number
from stiffcal.validation.schemes import BY_REGION, BY_REGION_AND_POSE, HOLDOUT_RUNS, LEAVE_ONE_POSE_OUT, held_out
from stiffcal.wording import angle, deviation, length, share

if TYPE_CHECKING:
    from stiffcal.measurements.rms import Rms
    from stiffcal.presentation.values import Level, Page
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.show.options import ShowOptions
    from stiffcal.validation.distance_results import Distances, DistanceSummary, LadderStep, TargetDistance
    from stiffcal.validation.elasticity_results import Elasticity, JointElasticity, JointVerdict
    from stiffcal.validation.results import ErrorSlice, WorstState

FEW_PARTS = 3
"""Rows of a table of errors by run, direction, load: without details."""
NOISE_IN_DISTANCE = (
    "noise alone: distances of a right model from the readings, σ the uncertainty of one axis: mean 1.60 σ, rms 1.73 σ"
)


def page(result: ValidateResult, options: ShowOptions) -> Page:
    """Return the error in held-out poses next to the noise, then its parts; with details all of them."""
    made = PageBuilder("Error in held-out data")
    units = Units.of_errors((result.rms, result.max, result.zero_model, result.noise))
    level, text = _verdict(result, units)
    made.say(text, "verdict", level)
    for line in result.failed:
        made.say(f"  NOT met: {line}", "threshold-failed")
    for line in result.not_judged:
        made.say(f"  not judged: {line}", "threshold-not-judged")
    made.add(parts.registration(result.registration))
    made.say(f"{held_out(result.scheme)} ({_scheme_words(result.scheme)})", "scheme")
    rows = [
        ("model", deviation(result.rms, units)),
        ("worst state", deviation(result.max, units)),
        ("no model", deviation(result.zero_model, units)),
        ("noise", "not known" if result.noise is None else deviation(result.noise, units)),
        (f"share of {whole_error(result)}", _shares(result.relative)),
    ]
    made.table(("", number("rms")), rows)
    if result.distance is not None:
        _add_distances(made, result.distance, result.ladder or [], options.details)
    made.add(elasticity_sentences(result.elasticity))
    slices = {
        "experiment": result.by_experiment,
        "body": result.by_body,
        "run": result.by_run,
        "direction": result.by_direction,
        "load": result.by_load,
        "branch": result.by_branch,
    }
    for title, members in slices.items():
        _add_slices(made, title, members or [], whole_error(result), None if options.details else FEW_PARTS)
    if result.worst:
        made.say(f"worst: {_worst(result.worst, units)}", "worst")
    made.add(parts.suspects(result.suspects, result.suspects_not_checked if options.details else None))
    limits = ", ".join(result.thresholds)
    if result.passed:
        made.say(f"thresholds met: {limits}" if limits else "no thresholds are set", "thresholds")
    return made.page()


def _scheme_words(scheme: str) -> str:
    """Return how data were left out: names of schemes in words, those of other experiments as they are."""
    words = {
        LEAVE_ONE_POSE_OUT: "each pose left out of the fit in turn",
        BY_REGION: "each of six regions of the joints' ranges left out of the fit in turn",
        BY_REGION_AND_POSE: "each of six regions of the absolute poses, and each pose of loads, left out in turn",
        HOLDOUT_RUNS: "the runs with holdout = true, which no fit uses",
        "none": "a single pose: nothing can be left out",
        "other campaign's model": "the model was fitted to another campaign",
    }
    return words.get(scheme, scheme)


def whole_error(result: ValidateResult) -> str:
    """Return what the error in held-out data is a share of: of absolute poses, what the nominal robot leaves."""
    only_places = result.distance is not None and not result.by_experiment
    return "the nominal robot's error" if only_places else "the deflection"


def elasticity_sentences(elasticity: Elasticity | None) -> list[Sentence]:
    """Return which joints' compliance absolute poses identify, and of the others why it is not claimed."""
    if elasticity is None:
        return []
    sentences = [Sentence((elasticity.why,), "elasticity")]
    reasons: dict[JointVerdict, list[JointElasticity]] = {}
    for joint in elasticity.joints:
        if joint.verdict != "identified":
            reasons.setdefault(joint.verdict, []).append(joint)
    for joints in reasons.values():
        numbers = ", ".join(str(joint.joint) for joint in joints)
        many = "s" if len(joints) > 1 else ""
        sentences.append(Sentence((f"  not claimed: joint{many} {numbers}: {joints[0].why}",), "not-claimed"))
    return sentences


def _verdict(result: ValidateResult, units: Units) -> tuple[Level, str]:
    """Return how the model stands in held-out data: against its thresholds, then against the noise."""
    text = f"error in {held_out(result.scheme)} {deviation(result.rms, units)} rms"
    text += f", noise {deviation(result.noise, units)}" if result.noise is not None else ", noise not known"
    if not result.passed:
        return "fail", f"thresholds NOT met: {text}"
    return ("pass", text) if is_within_noise(result.rms, result.noise) else ("warn", text)


def _add_distances(made: PageBuilder, distance: Distances, ladder: Sequence[LadderStep], details: bool) -> None:
    """Add the distances of the targets as details, and the ladder from the nominal robot to the present model.

    The last step of the ladder is the present model: where there is one, the distances state its errors once more.
    """
    if details or not ladder:
        _add_targets(made, distance)
    # poses at random are close to those that were fitted: a region decides
    rows = []
    for step in ladder:
        cells = [step.fit, step.heldout_random, step.heldout_region, step.mean_random, step.mean_region]
        rows.append((STEPS.get(step.step, step.step), str(step.n_parameters), *(length(v) for v in cells)))
    titles = (
        "model",
        number("parameters"),
        number("fit, rms"),
        number("random, rms", is_secondary=True),
        number("region, rms"),
        number("random, mean", is_secondary=True),
        number("region, mean"),
    )
    made.table(titles, rows)


def _add_targets(made: PageBuilder, distance: Distances) -> None:
    sizes = [distance.fit, distance.heldout_random, distance.heldout_region, distance.noise]
    units = Units([(LENGTH, [one.rms for one in sizes if one is not None])])
    rows: list[tuple[str, ...]] = []
    for title, summary in (
        ("fit", distance.fit),
        ("poses held out at random", distance.heldout_random),
        ("held-out regions", distance.heldout_region),
    ):
        if summary is None:
            continue
        members: list[tuple[str, DistanceSummary | TargetDistance]] = [(title, summary)]
        if len(summary.by_target) > 1:
            members += [(f"  {part.target}", part) for part in summary.by_target]
        for label, part in members:
            rows.append((label, *(length(v, units) for v in (part.mean, part.median, part.p95, part.max, part.rms))))
    noise = distance.noise
    if noise is not None:
        cells = (length(v, units) for v in (noise.mean, noise.median, noise.p95))
        rows.append(("noise alone", *cells, "", length(noise.rms, units)))
    made.table(("distance", *map(number, ("mean", "median", "95 %", "worst", "rms"))), rows)
    if noise is not None:
        made.say(NOISE_IN_DISTANCE, "noise-in-distance")


def _are_alike(slices: Sequence[ErrorSlice]) -> bool:
    """Return whether the errors of all parts are nearly the same, so that a table of them says nothing."""
    from stiffcal.results.validate_result import NEARLY_ALIKE

    errors = [part.rms.translation for part in slices if part.rms.translation]
    return len(errors) == len(slices) and max(errors) < NEARLY_ALIKE * min(errors)


def _add_slices(made: PageBuilder, title: str, slices: Sequence[ErrorSlice], whole: str, most: int | None) -> None:
    """Add the error in parts, the largest first; `most`: so many rows at most, None: all."""
    if len(slices) < 2 or (most is not None and _are_alike(slices)):
        return
    of_deflection = (number(f"share of {whole}"),) if slices[0].zero_model is not None else ()
    units = Units.of_errors(error for part in slices for error in (part.rms, part.max))
    ranked = sorted(slices, key=lambda part: -(part.rms.translation or 0.0))
    # a line that says one more takes the room of that one
    shown = ranked if most is None or len(ranked) <= most + 1 else ranked[:most]
    rows = []
    for part in shown:
        cells = [part.label, str(part.n), deviation(part.rms, units), deviation(part.max, units)]
        if of_deflection:
            of_all = None if part.zero_model is None else part.zero_model.translation
            cells.append(share((part.rms.translation or 0.0) / of_all) if of_all else "–")
        rows.append(cells)
    made.table((title, number("states"), number("rms"), number("max"), *of_deflection), rows)
    if len(shown) < len(ranked):
        made.say(f"  and {len(ranked) - len(shown)} more with smaller errors (validate --details)", "more")


def _shares(relative: Rms) -> str:
    words = {"motor_angle": "motors' angles", "length": "rods' lengths"}
    known = ((name, value) for name, value in relative.items() if value is not None)
    return ", ".join(f"{words.get(name, name)} {share(value)}" for name, value in known)


def _worst(worst: Sequence[WorstState], units: Units) -> str:
    def size(state: WorstState) -> str:
        return length(state.residual_m, units) if state.residual_rad is None else angle(state.residual_rad, units)

    def where(state: WorstState) -> str:
        # a row of absolute poses is a run of its own, and its name holds the row
        row = f"row {state.row}"
        return f"run {state.run}" if state.run.endswith(row) else f"run {state.run}, {row}"

    return "; ".join(f"{where(state)}: {size(state)}" for state in worst[:3])
