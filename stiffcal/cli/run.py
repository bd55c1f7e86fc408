"""`stiffcal run`: check to report in one go."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.diagnose import effect_words
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Folder, Overwrite, StoreAt
from stiffcal.cli.pages import draw_blocks
from stiffcal.cli.verdict import diagnosis_level, show_verdict
from stiffcal.cli.wording import deviation, length, share
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.results.next_step import Step
from stiffcal.show.answers.identify import add_fitted
from stiffcal.show.answers.validate import elasticity_sentences, whole_error
from stiffcal.show.builder import PageBuilder
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import listing

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.commands.run_result import RunResult
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.validation.distances import Distances
    from stiffcal.validation.elasticity import Elasticity


def run(folder: Folder = HERE, as_json: AsJson = False, store: StoreAt = None, overwrite: Overwrite = False) -> int:
    """Check, ingest, identify, validate, diagnose, report and view in one go.

    Example: stiffcal run demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.run import run_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(store=store, progress=answer.progress, notify=answer.notify, overwrite=overwrite)
        try:
            result = run_campaign(folder, context)
        except InputError as error:
            logs = ("sources", "runs")
            if all(fault.code is FaultCode.FILE_MISSING and fault.place.startswith(logs) for fault in error.faults):
                # nothing is wrong but that the logs are not there yet
                error.add_note(NextLine(command_line("check", folder, store=store)).text)
            raise
        page = command_line("view", folder, store=store)
        then = following(folder, store, Step.DIAGNOSE, done={Step.REPORT})
        answer.give(result, partial(show_run, page=page), then)
    return OK if result.passed else NOT_HELD


def show_run(console: AnswerConsole, result: RunResult, page: str) -> None:
    """Draw what is missing, the stiffness table, the error in held-out poses, where the PDF and the page are.

    Parameters
    ----------
    page : the command that writes the page for a browser.
    """
    show_verdict(
        console, diagnosis_level(result.diagnose.adequate, bool(result.diagnose.missing)), result.diagnose.summary
    )
    validation = result.validate
    for line in validation.failed:
        show_verdict(console, "fail", f"thresholds NOT met: {line}")
    console.show_warnings(result.check.warnings)
    console.show_warnings(result.identify.warnings)
    made = PageBuilder("Fit")
    add_fitted(made, result.identify, is_part=True, unclaimed=not_claimed(validation.elasticity))
    draw_blocks(console, made.page().blocks)
    relative = dict(validation.relative.items())
    error_share, of = relative["translation"], whole_error(validation)
    if error_share is None:
        error_share, of = relative.get("torque"), "the torque"
    if any(value is not None for _, value in validation.rms.items()):
        sentence = f"{held_out(validation.scheme)}: {deviation(validation.rms)} rms"
        sentence += f", {share(error_share)} of {of} is left" if error_share is not None else ""
        console.print(f"{sentence} (no model: {deviation(validation.zero_model)})")
    else:
        console.print("held-out poses: none, the error in new poses is not validated")
    if line := with_missing_in_words(result.diagnose):
        console.print(line, soft_wrap=True)
    if validation.distance is not None:
        console.print(f"mean distance: {_mean_distances(validation.distance)}", soft_wrap=True)
    draw_blocks(console, elasticity_sentences(validation.elasticity))
    console.show_warnings(validation.warnings)
    console.print(f"report: {result.report}", soft_wrap=True)
    console.print(f"in a browser: {result.view} (written by {page})", soft_wrap=True)


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
