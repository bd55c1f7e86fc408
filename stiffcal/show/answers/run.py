"""What `run` and `demo` show: what is missing, the fit, the error in held-out poses, where PDF and page are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import Units
from stiffcal.show.answers import history
from stiffcal.show.answers.identify import add_fitted
from stiffcal.show.answers.validate import elasticity_sentences, whole_error
from stiffcal.show.builder import PageBuilder
from stiffcal.show.effects import diagnosis_level, effect_words
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import deviation, length, listing, share

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.presentation.values import Page
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.show.options import ShowOptions
    from stiffcal.stages.run_result import RunResult
    from stiffcal.validation.distance_results import Distances
    from stiffcal.validation.elasticity_results import Elasticity


def page(result: RunResult, options: ShowOptions) -> Page:
    """Return what is missing, the stiffness table, the error in held-out poses, and the files; of `demo` all fits."""
    made, validation = PageBuilder("Check to report"), result.validate
    made.say(result.diagnose.summary, "verdict", diagnosis_level(result.diagnose))
    for line in validation.failed:
        made.say(f"thresholds NOT met: {line}", "threshold-failed", "fail")
    add_fitted(made, result.identify, is_part=True, unclaimed=not_claimed(validation.elasticity))
    made.say(_held_out_in_words(validation), "held-out")
    if line := with_missing_in_words(result.diagnose):
        made.say(line, "with-missing")
    if validation.distance is not None:
        made.say(f"mean distance: {_mean_distances(validation.distance)}", "distances")
    made.add(elasticity_sentences(validation.elasticity))
    made.say(f"report: {result.report}", "written")
    made.say(f"in a browser: {result.view} (written by {options.line('view')})", "written")
    if result.history is not None:
        made.head(f"history of fits (the hidden effect: {result.folder}/truth.json):")
        made.add(history.page(result.history, options).blocks)
    return made.page()


def _held_out_in_words(validation: ValidateResult) -> str:
    """Return the error in held-out poses, and how much of what is to be explained it is."""
    if all(value is None for _, value in validation.rms.items()):
        return "held-out poses: none, the error in new poses is not validated"
    relative = dict(validation.relative.items())
    error_share, of = relative["translation"], whole_error(validation)
    if error_share is None:
        error_share, of = relative.get("torque"), "the torque"
    left = f", {share(error_share)} of {of} is left" if error_share is not None else ""
    units = Units.of_errors((validation.rms, validation.zero_model))
    without = deviation(validation.zero_model, units)
    return f"{held_out(validation.scheme)}: {deviation(validation.rms, units)} rms{left} (no model: {without})"


def with_missing_in_words(diagnosis: DiagnoseResult) -> str:
    """Return the error in held-out data with all that is missing in the model; "" where nothing is missing."""
    if not diagnosis.missing or not diagnosis.heldout_rms_with_missing:
        return ""
    validated, names = diagnosis.as_validated, listing(map(effect_words, diagnosis.missing))
    if validated is not None and validated.with_missing is not None:
        return f"{held_out(validated.scheme)}, with {names} added: {deviation(validated.with_missing)} rms"
    rms = diagnosis.heldout_rms_with_missing
    return f"{held_out_by_diagnosis(diagnosis.rms)}, with {names} added: {deviation(rms)} rms"


def not_claimed(elasticity: Elasticity | None) -> frozenset[int]:
    """Return the joints whose compliance absolute poses give a value, but do not identify."""
    joints = [] if elasticity is None else elasticity.joints
    return frozenset(joint.joint for joint in joints if joint.verdict != "identified")


def _mean_distances(distance: Distances) -> str:
    """Return the mean distance between predicted and measured places, in what was fitted and in what was left out."""
    parts = (
        ("fitted", distance.fit),
        ("in poses held out at random", distance.heldout_random),
        ("in held-out regions", distance.heldout_region),
    )
    texts = [f"{length(summary.mean)} {where}" for where, summary in parts if summary is not None]
    if distance.noise is not None:
        texts.append(f"{length(distance.noise.mean)} of noise alone")
    return ", ".join(texts)
