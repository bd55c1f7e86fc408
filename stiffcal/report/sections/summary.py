"""The first page: the answer, what to do next, the stiffness, the ladder, and the robot with its soft places."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from stiffcal.diagnosis.results import ProposedEffect
from stiffcal.identification.before_after import BeforeAfter
from stiffcal.identification.state_kinds import state_kinds
from stiffcal.reduction.registration.frames import RegistrationSummary
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, Items, LeftOut, Paragraph, PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.estimates import estimate_text
from stiffcal.report.figures.ladder import Rung, leading_component
from stiffcal.report.figures.overview import draw_overview
from stiffcal.report.sections.campaign import MOST_WARNINGS, warnings_of
from stiffcal.report.sections.diagnosis import probable_law
from stiffcal.report.sections.experiments import table_of
from stiffcal.report.sections.stiffness import not_claimed, short_stiffness_table, where_words
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.next_step import Standing, Step, next_step
from stiffcal.results.registration_words import convention_in_words
from stiffcal.results.validate_result import ValidateResult
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import probability_in_words

ORDER = 10
NOT_YOURS = (
    "Not computed by you: these results came with the campaign folder, and the logs to recompute them are missing."
)


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the answer, what to do next, the stiffness, the ladder and the robot."""
    blocks: list[Block] = []
    if content.identify is not None and content.identify.origin == "foreign":
        blocks.append(Paragraph(NOT_YOURS, "key"))
    if content.ingest is not None and content.ingest.registration is not None:
        blocks.append(Paragraph(_registration_sentence(content.ingest.registration)))
    blocks.append(Paragraph(_verdict(content), "key"))
    blocks.append(Facts((("next step", _next_step(content)),)))
    sentences = _fit_sentences(content)
    if content.readings_alone and content.validate is not None:
        sentences += _heldout_readings(content.validate)
    else:
        sentences += _heldout_sentences(content)
    blocks.append(Paragraph(" ".join(sentences)))
    elasticity = None if content.validate is None else content.validate.elasticity
    if elasticity is not None and elasticity.verdict != "identified":
        # the table below lists what the fit gives, whether or not something else explains the same places
        blocks.append(Paragraph(f"{wording.capital(elasticity.why)}."))
    points = [f"Warning: {text}" for text in warnings_of(content)]
    if len(points) > MOST_WARNINGS:
        first = points[: MOST_WARNINGS - 1]
        points = [*first, f"{len(points) - len(first)} more warnings: see “The campaign”"]
    if points:
        blocks.append(Items(tuple(points)))
    blocks += _overview(content)
    return ReportSection("Summary", tuple(blocks))


def _verdict(content: ReportContent) -> str:
    """Return the answer of the diagnosis, with the error that the missing effects leave; why there is none else."""
    diagnosis = content.diagnose
    if diagnosis is None:
        return wording.capital(content.not_diagnosed)
    text = diagnosis.summary
    if diagnosis.in_model:
        text += f" In the model: {wording.listing(map(_held, diagnosis.in_model))}."
    if diagnosis.missing:
        before, after = wording.measure_text(diagnosis.rms), wording.measure_text(diagnosis.heldout_rms_with_missing)
        noise = f"; the noise is {wording.measure_text(diagnosis.noise)}" if diagnosis.noise else ""
        left_out = held_out_by_diagnosis(diagnosis.rms)
        text += f" Added to the model, it reduces the error in {left_out} from {before} to {after} rms"
        validated = diagnosis.as_validated
        if validated is not None and validated.with_missing is not None:
            before, after = wording.measure_text(validated.rms), wording.measure_text(validated.with_missing)
            text += f", in {held_out(validated.scheme)} from {before} to {after} rms"
        text += f"{noise}."
        text += _changed(diagnosis.before_after, content, "It")
    elif not diagnosis.unexplained and content.fit_changes:
        change = content.fit_changes[0]
        text += _changed(change.values, content, f"The change of the model ({change.change})")
    return text


def _held(effect: ProposedEffect) -> str:
    """Return an effect of the model with its probability, and with what looks the same."""
    names = [wording.effect_at(other) for other in effect.alternatives]
    alike = f", or {wording.listing(names)}" if names else ""
    return f"{wording.effect_at(effect)}{alike}: {probability_in_words(effect.probability or 0.0)}"


def _changed(values: Sequence[BeforeAfter], content: ReportContent, cause: str) -> str:
    """Return the stiffness that moved most beyond its 95 % interval; "" where none did."""
    moved = [
        value for value in values
        if value.outside_interval and value.relative is not None and value.where.joints and value.unit == "N·m/rad"
    ]  # fmt: skip
    if not moved:
        return ""
    most = max(moved, key=lambda value: abs(value.relative or 0.0))
    before, after = (
        estimate_text(value.value, value.interval) for value in (most.before, most.after) if value is not None
    )
    place = where_words(most.where, content.joint_names)
    return f" {cause} changes the stiffness of {place} most: from {before} to {after} {most.unit}."


def _next_step(content: ReportContent) -> str:
    """Return the command or the measurement that the answer calls for."""
    diagnosis = content.diagnose
    validation = content.validate
    standing = Standing(
        logs_missing=False,
        is_fitted=True,
        heldout_rms=None if validation is None else validation.rms,
        noise=None if validation is None else validation.noise,
        diagnosis=diagnosis,
    )
    step = next_step(standing, Step.VALIDATE)
    if step in (Step.DIAGNOSE, Step.IMPROVE):
        return f"stiffcal {step.value} DIR"
    if diagnosis is None:
        return "none: use the model (stiffcal predict, map, compensate)"
    if diagnosis.undecided:
        return "repeat the poses on which the result depends, then run stiffcal diagnose"
    if diagnosis.pattern is not None:
        return "test the pattern under “Missing effects”: stiffcal effects new NAME --from DIR"
    if diagnosis.unexplained and not diagnosis.structure and (law := probable_law(diagnosis)):
        return f"see “Missing effects”: what is left is probably {law}"
    if diagnosis.unexplained and not diagnosis.structure:
        return "see “Missing effects”: the remaining error follows none of the variables that were tried"
    if diagnosis.unexplained:
        return "see “Missing effects”: variables on which the remaining error depends"
    removes = "; stiffcal remove DIR EFFECT takes out what is not needed" if diagnosis.superfluous else ""
    return f"none: use the model (stiffcal predict, map, compensate){removes}"


def _overview(content: ReportContent) -> list[Block]:
    """Return the table of stiffness, and the ladder next to the robot."""
    blocks: list[Block] = []
    if content.identify is not None:
        table = short_stiffness_table(
            content.identify.parameters, content.parameters_on_pages, content.joint_names, not_claimed(content)
        )
        blocks += [table] if table is not None else []
        if content.readings_alone:
            blocks += [table_of(table, "Results of these runs, ± 95 %.") for table in content.main_tables]
    fits = [] if content.history is None else content.history.fits
    zero = None if content.validate is None else content.validate.zero_model
    present = None if content.identify is None else content.identify.fit_id
    drawn_fits = sorted(fits, key=lambda fit: fit.id == present)
    component = leading_component(drawn_fits)
    if component is not None:
        run = next((run for run in content.runs if run.stick is not None), None) if content.place_shares else None
        caption = f"Error in {content.held_out} for each fit"
        if run is not None:
            caption += (
                f"; robot in the pose of run {run.name}, with the share of each place in the predicted deflection of "
                f"all runs"
            )
        blocks.append(
            PictureBlock(
                partial(
                    draw_overview,
                    drawn_fits,
                    zero,
                    content.known_noise,
                    run,
                    content.place_shares,
                    _expected(content, component),
                    component,
                ),
                f"{caption}.",
            )
        )
    return blocks


def _expected(content: ReportContent, component: str) -> Rung | None:
    """Return the rung that adding the missing effects would reach; None where none is missing."""
    diagnosis = content.diagnose
    if diagnosis is None or not diagnosis.missing:
        return None
    names = "; ".join(f"+ {wording.effect_at(effect)}" for effect in diagnosis.missing)
    validated = diagnosis.as_validated
    reached = diagnosis.heldout_rms_with_missing if validated is None else validated.with_missing
    return Rung(f"expected: {names}", wording.part(reached, component), None)


def _registration_sentence(registration: RegistrationSummary) -> str:
    """Return how well the kinematics meets the places by which frames were estimated."""
    missed = wording.measure_text({"translation": registration.rms_m, "rotation": registration.rms_rad})
    return (
        f"Registration of {wording.listing(registration.frames)} in {wording.count(registration.n_poses, 'pose')}: "
        f"measured and predicted positions differ by {missed} rms."
        + "".join(
            f" {convention_in_words(name, frame)}."
            for name, frame in registration.frames.items()
            if frame.by_convention
        )
    )


def _fit_sentences(content: ReportContent) -> list[str]:
    if content.identify is None:
        return ["No model has been fitted yet; this report shows the measurements."]
    fit = content.identify
    if content.readings_alone:
        return [_readings_sentence(content, fit)]
    states = f"{wording.count(fit.n_states, 'load state')} in {wording.count(fit.n_runs, 'run')}"
    if content.absolute_alone:
        states = wording.count(fit.n_states, "pose")
    model, robot = wording.model_words(fit.model), the_robot(content.provenance.robot)
    text = f"The model ({model}) was fitted to {states} of {robot}"
    return [f"{text}; residual of the fit: {wording.measure_text(fit.rms)} rms."]


def the_robot(name: str) -> str:
    """Return a robot's name in a sentence, with one article.

    Examples
    --------
    >>> the_robot("KUKA KR 125"), the_robot("a six-axis robot"), the_robot("The arm")
    ('the KUKA KR 125', 'the six-axis robot', 'the arm')
    """
    article, _, rest = name.partition(" ")
    return f"the {rest if rest and article.lower() in ('a', 'an', 'the') else name}"


def _readings_sentence(content: ReportContent, fit: IdentifyResult) -> str:
    model = f"The model ({wording.model_words(fit.model)})"
    fitted_model = (content.readings_alone[0].fitted if len(content.readings_alone) == 1 else "") or model
    readings = wording.count(fit.n_readings, "reading") if fit.n_readings else wording.count(fit.n_states, "state")
    return (
        f"{fitted_model} of {the_robot(content.provenance.robot)} was fitted to {readings} in "
        f"{wording.count(fit.n_runs, 'run')}; residual of the fit: {wording.measure_text(fit.rms)} rms."
    )


def _heldout_readings(validation: ValidateResult) -> list[str]:
    measured = {"torque": "torque", "motor_angle": "motor's angle"}
    measure = next((name for name in measured if wording.part(validation.rms, name) is not None), None)
    if measure is None:
        return ["It cannot be validated: each joint was driven in only one usable pose."]
    of_states = (kind.left_out for kind in state_kinds().values() if kind.measure == measure)
    where = next(of_states, f"data ({validation.scheme})")
    sentences = [f"Error in held-out {where}: {wording.measure_text(validation.rms)} rms"]
    sentences[0] += f", without a model {wording.measure_text(validation.zero_model)}"
    left = wording.part(validation.relative, measure)
    predicted = "." if left is None else f": {wording.percent(1.0 - left)} of the {measured[measure]} is predicted."
    sentences[0] += predicted
    if validation.noise is not None:
        sentences.append(f"The noise is {wording.measure_text(validation.noise)} rms.")
    else:
        sentences.append("The noise is unknown: too few repeats.")
    return sentences


def _heldout_sentences(content: ReportContent) -> list[str]:
    """Give the error to expect in new poses, with the deflection itself and the noise."""
    validation = content.validate
    if validation is None:
        return ["The error in new poses is not known yet (no validation)."]
    whole = "an error of the nominal robot" if content.absolute_alone else "a deflection"
    error = (
        f"Error in {content.held_out}: {wording.measure_text(validation.rms)} rms at {whole} of "
        f"{wording.measure_text(validation.zero_model)}"
    )
    left = validation.relative.translation
    if left is not None:
        what = "that error" if content.absolute_alone else "the deflection"
        error += f": {wording.percent(1.0 - left)} of {what} is predicted"
    sentences = [f"{error}."]
    if content.known_noise == validation.noise:  # else the answer above states the noise
        sentences.append(noise_sentence(validation))
    if not validation.passed:
        sentences.append("The thresholds of the campaign are exceeded.")
    return sentences


def noise_sentence(validation: ValidateResult) -> str:
    """Return what the instruments scatter, or that this cannot be judged."""
    if wording.part(validation.noise, "translation") is not None:
        return f"Noise of instruments and load application: {wording.measure_text(validation.noise)} rms."
    return "The noise is unknown: no load was repeated, and the manifest states no uncertainty of the instruments."
