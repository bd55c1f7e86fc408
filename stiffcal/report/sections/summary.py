"""The first page: the answer, what to do next, the stiffness, the ladder, and the robot with its soft places."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Literal

from stiffcal.diagnosis.answers.results import ProposedEffect
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import STIFFNESS
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Facts,
    Items,
    LeftOut,
    NumbersBlock,
    Paragraph,
    PictureBlock,
    ReportSection,
    VerdictBlock,
)
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.evidence import draw_evidence
from stiffcal.report.figures.ladder import Rung, ladder_rungs, leading_component
from stiffcal.report.figures.overview import MOST_RUNGS, draw_overview
from stiffcal.report.fit_sentences import fit_sentences
from stiffcal.report.page_blocks import table_of
from stiffcal.report.sections.campaign import MOST_WARNINGS, warnings_of
from stiffcal.report.sections.diagnosis import probable_law
from stiffcal.report.sections.stiffness import not_claimed, short_stiffness_table, where_words
from stiffcal.results.model_words import STEPS
from stiffcal.results.next_step import Standing, Step, next_step
from stiffcal.results.validate_result import ValidateResult
from stiffcal.wording import estimate, probability_in_words

ORDER, IN_SHORT = 10, True
NOT_YOURS = (
    "Not computed by you: these results came with the campaign folder, and the logs to recompute them are missing."
)


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the answer, what to do next, the stiffness, the ladder and the robot."""
    blocks: list[Block] = []
    if identity := _identity(content):
        blocks.append(Facts(identity))
    if content.identify is not None and content.identify.origin == "foreign":
        blocks.append(Paragraph(NOT_YOURS, "key"))
    blocks.append(VerdictBlock(_level(content), _verdict(content)))
    numbers = _numbers(content)
    if numbers:
        blocks.append(NumbersBlock(numbers))
    blocks.append(Facts((*_about_the_model(content), ("next step", _next_step(content)))))
    blocks += _residual(content)
    blocks.append(Paragraph(" ".join(fit_sentences(content))))
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


def _identity(content: ReportContent) -> tuple[tuple[str, str], ...]:
    """Return which robot was measured, where, when, by whom and with what, as far as campaign.toml states it."""
    stated = content.settings
    robot = content.provenance.robot + (f", serial number {stated.serial_number}" if stated.serial_number else "")
    by = stated.operator and f"by {stated.operator}"
    measured = ", ".join(text for text in (stated.measured, stated.site, stated.temperature, by) if text)
    with_what = "; ".join(
        ", ".join(
            text
            for text in (
                one.name,
                one.certificate and f"certificate {one.certificate}",
                one.certified and f"of {one.certified}",
            )
            if text
        )
        for one in stated.instruments
    )
    rows = (("measured", measured), ("instruments", with_what))
    known = tuple((name, text) for name, text in rows if text)
    return (("robot", robot), *known) if known or stated.serial_number else ()


def _verdict(content: ReportContent) -> str:
    """Return the answer of the diagnosis in a sentence; why there is none else."""
    return wording.capital(content.not_diagnosed) if content.diagnose is None else content.diagnose.summary


def _level(content: ReportContent) -> Literal["ok", "attention", "not usable"]:
    """Return how far the model can be used: not at all where it predicts new data no better than no model does."""
    validation, diagnosis = content.validate, content.diagnose
    if content.identify is None or (validation is not None and not _predicts(validation)):
        return "not usable"
    is_passed = validation is None or validation.passed
    is_adequate = diagnosis is not None and bool(diagnosis.adequate) and not diagnosis.missing
    return "ok" if is_passed and is_adequate else "attention"


def _predicts(validation: ValidateResult) -> bool:
    """Return whether errors in held-out data are smaller than without a model, in some measure."""
    known = [share for _, share in validation.relative.items() if share is not None]
    return not known or min(known) < 1.0


def _numbers(content: ReportContent) -> tuple[tuple[str, str], ...]:
    """Return the error before and after what is missing, or was added, and the noise."""
    validation, diagnosis = content.validate, content.diagnose
    if validation is None:
        return ()
    left_out = content.held_out
    nominal = "of the nominal robot" if content.absolute_alone else "without a model"
    before: tuple[str, Rms | None] = (f"error {nominal}", validation.zero_model)
    after: tuple[str, Rms | None] = (f"error in {left_out}", validation.rms)
    added = _last_change(content)
    if diagnosis is not None and diagnosis.missing:
        judged = diagnosis.as_validated
        with_missing = diagnosis.heldout_rms_with_missing if judged is None else judged.with_missing
        rms = diagnosis.rms if judged is None else judged.rms
        before, after = (f"error in {left_out}", rms), ("error with what is missing", with_missing)
    elif added is not None:
        before = ("error before the change", added[1])
    noise = content.known_noise
    numbers = (before, after, ("noise", noise))
    return tuple((name, "not known" if rms is None else _leading(rms)) for name, rms in numbers)


def _leading(rms: Rms) -> str:
    """Return the first measure of an error: the place where it was measured."""
    name = next((name for name, value in rms.items() if value is not None), None)
    return wording.DASH if name is None else wording.measure_text({name: wording.part(rms, name)})


def _last_change(content: ReportContent) -> tuple[str, Rms] | None:
    """Return what led from the first model to the present one, and the error in held-out data before; None of nothing.

    Where several changes did, the first of `fit_changes` is all of them together.
    """
    if not content.fit_changes or content.history is None:
        return None
    change = content.fit_changes[0]
    before = next((fit.heldout_rms for fit in content.history.fits if fit.id == change.before), None)
    return None if before is None else (change.change, before)


def _about_the_model(content: ReportContent) -> list[tuple[str, str]]:
    """Return what was added and what it did to the error and to the values, and what looks the same."""
    diagnosis, validation = content.diagnose, content.validate
    facts: list[tuple[str, str]] = []
    if content.set_aside:
        n_rows = sum(max(len(rows.rows), 1) for rows in content.set_aside)
        why = wording.listing(dict.fromkeys(rows.why for rows in content.set_aside), 3)
        facts.append(("left out", f"{wording.count(n_rows, 'reading')}: {why} (see “The campaign”)."))
    added = _last_change(content)
    if added is not None and validation is not None:
        before, after = wording.measure_text(added[1]), wording.measure_text(validation.rms)
        text = f"{added[0]}: the error in {content.held_out} changed from {before} to {after} rms."
        if diagnosis is None or not (diagnosis.unexplained or diagnosis.missing):
            text += _changed(content.fit_changes[0].values, content, "It")
        facts.append(("added", text))
    if diagnosis is None:
        return facts
    if diagnosis.missing:
        cause = "Adding it" if len(diagnosis.missing) == 1 else "Adding them"
        changed = _changed(diagnosis.before_after, content, cause)
        facts.append(("missing", f"{'; '.join(map(_held, diagnosis.missing))}.{changed}"))
    if diagnosis.in_model:
        facts.append(("in the model", f"{'; '.join(map(_held, diagnosis.in_model))}."))
    return facts


def _held(effect: ProposedEffect) -> str:
    """Return an effect with its probability, and with what looks the same."""
    names = [wording.effect_at(other) for other in effect.alternatives]
    alike = f", or {wording.listing(names)}" if names else ""
    return f"{wording.effect_at(effect)}{alike}: {probability_in_words(effect.probability or 0.0)}"


def _residual(content: ReportContent) -> list[Block]:
    """Return the residual without and with the first effect that is missing, or was added, on one scale."""
    drawn = next((one for one in content.evidence if one.can_be_drawn), None)
    if drawn is None:
        return []
    caption = (
        f"Residual in held-out poses against {drawn.evidence.driver}: without {wording.effect_at(drawn.evidence)}, and "
        f"with it ({'the model lacks it' if drawn.missing else 'as the model is'})."
    )
    return [PictureBlock(partial(draw_evidence, drawn, example=False), caption)]


def _changed(values: Sequence[BeforeAfter], content: ReportContent, cause: str) -> str:
    """Return the stiffness that moved most beyond its 95 % interval; "" where none did."""
    moved = [
        value for value in values
        if value.outside_interval and value.relative is not None and value.where.joints and value.quantity == STIFFNESS
    ]  # fmt: skip
    if not moved:
        return ""
    most = max(moved, key=lambda value: abs(value.relative or 0.0))
    unit = STIFFNESS.usual
    before, after = (
        estimate(value.value, value.interval, unit.factor) for value in (most.before, most.after) if value is not None
    )
    place = where_words(most.where, content.joint_names)
    return f" {cause} changes the stiffness of {place} most: from {before} to {after} {unit.name}."


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
    if diagnosis is None:
        return f"stiffcal {Step.DIAGNOSE.value} DIR"
    step = next_step(standing, Step.VALIDATE)
    if step is Step.DIAGNOSE or step is Step.IMPROVE:
        return f"stiffcal {step.value} DIR"
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
    removes = "; remove what is not needed: stiffcal remove" if diagnosis.superfluous else ""
    # a model of friction alone gives under no load
    bends = content.identify is None or content.identify.has_states
    use = "stiffcal predict, map, compensate" if bends else "stiffcal export DIR -o model.json"
    return f"use the model: {use}{removes}"


def _overview(content: ReportContent) -> list[Block]:
    """Return the table of stiffness, and the ladder next to the robot."""
    blocks: list[Block] = []
    if content.identify is not None:
        table = short_stiffness_table(
            content.identify.parameters,
            content.parameters_on_pages,
            content.joint_names,
            not_claimed(content),
            content.diagnose.before_after if content.diagnose is not None and content.diagnose.missing else (),
        )
        blocks += [table] if table is not None else []
        if content.readings_alone:
            blocks += [table_of(table, "Results of these runs, ± 95 %.") for table in content.main_tables]
    rungs, component = first_page_ladder(content)
    if rungs:
        run = next((run for run in content.runs if run.stick is not None), None) if content.place_shares else None
        caption = f"Error in {content.held_out} for each {'step' if has_steps(content) else 'fit'}"
        if run is not None:
            caption += (
                f"; robot in the pose of run {run.name}, with the share of each place in the predicted deflection of "
                f"all runs"
            )
        picture = partial(draw_overview, rungs, content.known_noise, run, content.place_shares, component)
        blocks.append(PictureBlock(picture, f"{caption}."))
    return blocks


def has_steps(content: ReportContent) -> bool:
    """Return whether the ladder is that of a calibration: nominal robot, frames, geometry, springs."""
    return content.absolute_alone and content.validate is not None and bool(content.validate.ladder)


def first_page_ladder(content: ReportContent) -> tuple[list[Rung], str]:
    """Return the ladder of the first page, from the top down, and the measure of its errors; empty for none."""
    validation = content.validate
    if has_steps(content) and validation is not None:
        steps = validation.ladder or []
        return [Rung(STEPS.get(step.step, step.step), step.heldout_region, step.fit) for step in steps], "translation"
    fits = [] if content.history is None else content.history.fits
    present = None if content.identify is None else content.identify.fit_id
    drawn_fits = sorted(fits, key=lambda fit: fit.id == present)
    component = leading_component(drawn_fits)
    if component is None:
        return [], ""
    rungs = ladder_rungs(drawn_fits[-MOST_RUNGS:], None if validation is None else validation.zero_model, component)
    expected = _expected(content, component)
    return rungs + ([expected] if expected is not None else []), component


def _expected(content: ReportContent, component: str) -> Rung | None:
    """Return the rung that adding the missing effects would reach; None where none is missing."""
    diagnosis = content.diagnose
    if diagnosis is None or not diagnosis.missing:
        return None
    names = "; ".join(f"+ {wording.effect_at(effect)}" for effect in diagnosis.missing)
    validated = diagnosis.as_validated
    reached = diagnosis.heldout_rms_with_missing if validated is None else validated.with_missing
    return Rung(f"expected: {names}", wording.part(reached, component), None)
