"""`stiffcal validate`: the model against measurement in held-out poses."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, StoreAt, Thresholds
from stiffcal.cli.registration import show_registration
from stiffcal.cli.suspects import show_suspects
from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import Level, show_verdict
from stiffcal.cli.wording import angle, deviation, length, share
from stiffcal.results.next_step import Step, is_within_noise
from stiffcal.validation.schemes import BY_REGION, BY_REGION_AND_POSE, HOLDOUT_RUNS, LEAVE_ONE_POSE_OUT, held_out

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.measurements.rms import Rms
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.validation.distances import Distances, DistanceSummary, LadderStep, TargetDistance
    from stiffcal.validation.elasticity import Elasticity, JointElasticity, JointVerdict
    from stiffcal.validation.results import ErrorSlice, WorstState

FEW_PARTS = 3
"""Rows of a table of errors by run, direction, load: without details."""
NOISE_IN_DISTANCE = (
    "noise alone: distances of a right model from the readings, σ the uncertainty of one axis: mean 1.60 σ, rms 1.73 σ"
)


def validate(
    folder: Folder = HERE,
    model: Annotated[
        Path | None,
        typer.Option(
            "--model", metavar="OTHER_DIR", help="Validate the fitted model of another campaign with these data."
        ),
    ] = None,
    thresholds: Thresholds = None,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Validate the model in held-out poses, runs or regions.

    Lists the largest errors. Exit code 1 if a threshold of campaign.toml, or of --thresholds, is exceeded.

    Example: stiffcal validate demo
    """
    with answering(as_json) as answer:
        from stiffcal.campaign.thresholds import load_thresholds
        from stiffcal.commands.validate import validate_campaign
        from stiffcal.stages.steps import RunContext

        file = load_thresholds(thresholds) if thresholds else None
        reach = (folder, *([model] if model else []), *(file.baselines() if file else []))
        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, reach=reach
        )
        result = validate_campaign(folder, context, model=model, thresholds=file)
        # another campaign's model is no step of this one's loop
        after = Step.VALIDATE if model is None else None
        answer.give(result, partial(show_validation, details=details), following(folder, store, after))
    return OK if result.passed else NOT_HELD


def show_validation(console: AnswerConsole, result: ValidateResult, details: bool) -> None:
    """Draw the error in held-out poses next to the noise, then where it is largest, then what does not hold.

    Parameters
    ----------
    console : where to. result : the validation. details : also parts of smaller errors.
    """
    show_verdict(console, *_verdict(result))
    for line in result.failed:
        console.print(f"  NOT met: {line}", soft_wrap=True)
    for line in result.not_judged:
        console.print(f"  not judged: {line}", soft_wrap=True)
    console.show_warnings(result.warnings)
    show_registration(console, result.registration)
    console.print(f"{held_out(result.scheme)} ({_scheme_words(result.scheme)})", soft_wrap=True)
    table = plain_table("", "rms>")
    table.add_row("model", deviation(result.rms))
    table.add_row("worst state", deviation(result.max))
    table.add_row("no model", deviation(result.zero_model))
    table.add_row("noise", deviation(result.noise) if result.noise is not None else "not known")
    table.add_row(f"share of {whole_error(result)}", _shares(result.relative))
    console.print(table)
    if result.distance is not None:
        _show_distances(console, result.distance, result.ladder or [], details)
    show_elasticity(console, result.elasticity)
    slices = {
        "experiment": result.by_experiment,
        "body": result.by_body,
        "run": result.by_run,
        "direction": result.by_direction,
        "load": result.by_load,
        "branch": result.by_branch,
    }
    for title, parts in slices.items():
        _show_slices(console, title, parts or [], whole_error(result), None if details else FEW_PARTS)
    if result.worst:
        console.print(f"worst: {_worst(result.worst)}")
    show_suspects(console, result.suspects, result.suspects_not_checked if details else None)
    limits = ", ".join(result.thresholds)
    if result.passed:
        console.print(f"thresholds met: {limits}" if limits else "no thresholds are set")


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


def show_elasticity(console: AnswerConsole, elasticity: Elasticity | None) -> None:
    """Print which joints' compliance absolute poses identify, and of the others why it is not claimed."""
    if elasticity is None:
        return
    console.print(elasticity.why, soft_wrap=True)
    reasons: dict[JointVerdict, list[JointElasticity]] = {}
    for joint in elasticity.joints:
        if joint.verdict != "identified":
            reasons.setdefault(joint.verdict, []).append(joint)
    for joints in reasons.values():
        numbers = ", ".join(str(joint.joint) for joint in joints)
        many = "s" if len(joints) > 1 else ""
        console.print(f"  not claimed: joint{many} {numbers}: {joints[0].why}", soft_wrap=True)


def _verdict(result: ValidateResult) -> tuple[Level, str]:
    """Return how the model stands in held-out data: against its thresholds, then against the noise."""
    text = f"error in {held_out(result.scheme)} {deviation(result.rms)} rms"
    text += f", noise {deviation(result.noise)}" if result.noise is not None else ", noise not known"
    if not result.passed:
        return "fail", f"thresholds NOT met: {text}"
    return ("pass", text) if is_within_noise(result.rms, result.noise) else ("warn", text)


def _show_distances(console: AnswerConsole, distance: Distances, ladder: Sequence[LadderStep], details: bool) -> None:
    """Draw the distances of the targets as details, and the ladder from the nominal robot to the present model.

    The last step of the ladder is the present model: where there is one, the distances state its errors once more.
    """
    if details or not ladder:
        _show_targets(console, distance)
    _show_ladder(console, ladder)


def _show_targets(console: AnswerConsole, distance: Distances) -> None:
    table = plain_table("distance", "mean>", "median>", "95 %>", "worst>", "rms>")
    for title, summary in (
        ("fit", distance.fit),
        ("poses held out at random", distance.heldout_random),
        ("held-out regions", distance.heldout_region),
    ):
        if summary is None:
            continue
        parts: list[tuple[str, DistanceSummary | TargetDistance]] = [(title, summary)]
        if len(summary.by_target) > 1:
            parts += [(f"  {part.target}", part) for part in summary.by_target]
        for label, part in parts:
            table.add_row(label, *(length(v) for v in (part.mean, part.median, part.p95, part.max, part.rms)))
    noise = distance.noise
    if noise is not None:
        table.add_row("noise alone", length(noise.mean), length(noise.median), length(noise.p95), "", length(noise.rms))
    console.print(table)
    if noise is not None:
        console.print(NOISE_IN_DISTANCE, soft_wrap=True)


def _show_ladder(console: AnswerConsole, ladder: Sequence[LadderStep]) -> None:
    table = plain_table(
        "model", "parameters>", "fit, rms>", "random, rms>", "region, rms>", "random, mean>", "region, mean>"
    )
    for step in ladder:
        cells = [step.fit, step.heldout_random, step.heldout_region, step.mean_random, step.mean_region]
        table.add_row(step.step, str(step.n_parameters), *("–" if v is None else length(v) for v in cells))
    console.print(table)


def _are_alike(parts: Sequence[ErrorSlice]) -> bool:
    """Return whether the errors of all parts are nearly the same, so that a table of them says nothing."""
    from stiffcal.results.validate_result import NEARLY_ALIKE

    errors = [part.rms.translation for part in parts if part.rms.translation]
    return len(errors) == len(parts) and max(errors) < NEARLY_ALIKE * min(errors)


def _show_slices(console: AnswerConsole, title: str, parts: Sequence[ErrorSlice], whole: str, most: int | None) -> None:
    if len(parts) < 2 or (most is not None and _are_alike(parts)):
        return
    of_deflection = (f"share of {whole}>",) if parts[0].zero_model is not None else ()
    table = plain_table(title, "states>", "rms>", "max>", *of_deflection)
    ranked = sorted(parts, key=lambda part: -(part.rms.translation or 0.0))
    # a line that says one more takes the room of that one
    shown = ranked if most is None or len(ranked) <= most + 1 else ranked[:most]
    for part in shown:
        cells = [part.label, str(part.n), deviation(part.rms), deviation(part.max)]
        if of_deflection:
            of_all = None if part.zero_model is None else part.zero_model.translation
            cells.append(share((part.rms.translation or 0.0) / of_all) if of_all else "–")
        table.add_row(*cells)
    console.print(table)
    if len(shown) < len(ranked):
        console.print(f"  and {len(ranked) - len(shown)} more with smaller errors (--details)")


def _shares(relative: Rms) -> str:
    words = {"motor_angle": "motors' angles", "length": "rods' lengths"}
    known = ((name, value) for name, value in relative.items() if value is not None)
    return ", ".join(f"{words.get(name, name)} {share(value)}" for name, value in known)


def _worst(worst: Sequence[WorstState]) -> str:
    def size(state: WorstState) -> str:
        return length(state.residual_m) if state.residual_rad is None else angle(state.residual_rad)

    def where(state: WorstState) -> str:
        # a row of absolute poses is a run of its own, and its name holds the row
        row = f"row {state.row}"
        return f"run {state.run}" if state.run.endswith(row) else f"run {state.run}, {row}"

    return "; ".join(f"{where(state)}: {size(state)}" for state in worst[:3])
