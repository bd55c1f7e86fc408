"""The evidence for each missing effect: the residual against what drives it, before and after.

That for effects that the model holds already is in an appendix, `stiffcal.report.sections.evidence_appendix`.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.diagnosis.answers.results import DiagnoseResult, EffectEvidenceSummary
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, LeftOut, Paragraph, PictureBlock, ReportSection, SubheadingBlock
from stiffcal.report.content import EvidenceFigure, ReportContent
from stiffcal.report.figures.evidence import MOST_POINTS, draw_errors_by_run, draw_evidence
from stiffcal.results.value_words import value_text
from stiffcal.validation.schemes import held_out_by_diagnosis

ORDER = 74
_TITLE = "Evidence for the missing effects"
# A chart with more runs than this has marks too close to distinguish.
_MOST_RUNS = 60


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out the evidence for each effect that is missing."""
    if content.diagnose is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    figures = [figure for figure in content.evidence if figure.missing]
    if not figures:
        why = _why_none(content.diagnose)
        return LeftOut(_TITLE, why) if why else None
    blocks: list[Block] = [Paragraph(HOW_JUDGED)]
    for figure in figures:
        blocks.extend(evidence_of(content.diagnose, figure))
    return ReportSection(_TITLE, tuple(blocks))


HOW_JUDGED = (
    "Each effect is judged alone: the model is refitted without it, all other parameters free, and both models "
    "predict each pose from the other poses only. What is drawn is the residual along the direction in which the "
    "effect moves the target; for an effect of a load with several components, as a tilting moment, the component that "
    "would cause the residual, in the effect's mean motion. A real effect shows a pattern in the left figure and none "
    "in the middle one."
)


def _why_none(diagnosis: DiagnoseResult) -> str:
    """Return why there is no evidence to show; "" where nothing is missing."""
    if diagnosis.missing:
        return "for effects of moving joints see the figures of friction"
    if diagnosis.unexplained:
        return "no effect of the catalogue explains the remaining error"
    if not diagnosis.has_searched:
        return "no load states to judge effects by"
    return ""


def evidence_of(diagnosis: DiagnoseResult, figure: EvidenceFigure, by_run: bool = True) -> list[Block]:
    """Lay out the evidence for one effect.

    Parameters
    ----------
    diagnosis : of the present fit. figure : the effect. by_run : with the chart of errors run by run.
    """
    evidence = figure.evidence
    blocks: list[Block] = [SubheadingBlock(f"{wording.effect_at(evidence)}: {evidence.status}")]
    text = figure.seen or f"{wording.capital(figure.fingerprint or figure.summary)}."
    blocks.append(Paragraph(f"{text} {_rms_reduction_words(evidence)}"))
    facts = [("description", wording.capital(figure.summary) + ".")]
    if figure.parameters:
        facts.append(
            (
                "as fitted, ± 95 %",
                "; ".join(_parameter_words(parameter) for parameter in figure.parameters),
            )
        )
    if figure.seen:
        names = [wording.effect_at(alternative) for alternative in figure.alternatives]
        facts.append(("look-alikes", wording.listing(names, 6) if names else "nothing else in the catalogue"))
    if figure.check:
        facts.append(("check", figure.check))
    blocks.append(Facts(tuple(facts)))
    if figure.can_be_drawn:
        blocks.append(PictureBlock(partial(draw_evidence, figure), _caption(figure)))
    if by_run and 1 < len(evidence.by_run) <= _MOST_RUNS:
        noise = wording.part(diagnosis.noise, evidence.component)
        better = sum(run.after < run.before for run in evidence.by_run)
        caption = (
            f"Error by run without and with {evidence.effect}: it decreases in {better} of {len(evidence.by_run)} runs."
        )
        blocks.append(PictureBlock(partial(draw_errors_by_run, figure, noise), caption))
    return blocks


def _rms_reduction_words(evidence: EffectEvidenceSummary) -> str:
    before, after = (
        wording.measure_text(evidence.heldout_rms_before),
        wording.measure_text(evidence.heldout_rms_after),
    )
    left_out = held_out_by_diagnosis(evidence.heldout_rms_before)
    if evidence.status == "missing":
        return f"Error in {left_out}: {before} rms without it, {after} with it."
    return f"Error of the present model in {left_out}: {after} rms; without {evidence.effect}: {before}."


def _caption(figure: EvidenceFigure) -> str:
    evidence = figure.evidence
    text = (
        f"Residual in held-out poses against {evidence.driver}, without {evidence.effect} (left) and with it "
        f"(middle), same scale."
    )
    if evidence.lever is not None and not figure.of_motors:
        where = wording.place(evidence.where)
        text += (
            f" The residual of each state is converted to the equivalent motion at {where}, times the mean lever arm "
            f"of {wording.significant(evidence.lever)} m."
        )
    n_known, n_all = int(np.isfinite(figure.before).sum()), len(figure.before)
    if n_known < n_all:
        why = "its influence there is negligible" if evidence.lever is None else "no lever arm"
        text += f" {n_all - n_known} of {wording.count(n_all, 'state')} are not drawn: {why}."
    if n_known > MOST_POINTS:
        text += f" About {MOST_POINTS} states are drawn, including the largest residuals."
    if figure.path_run:
        text += f" The line connects the states of run {figure.path_run} in order; the other runs are grey."
    if figure.picture is not None:
        text += f" Right: {figure.picture.caption[0].lower()}{figure.picture.caption[1:]}"
    return text


def _parameter_words(parameter: IdentifiedParameter) -> str:
    unit = parameter.quantity.unit_for([parameter.value])
    symbol = parameter.name.rpartition(".")[2]
    estimate = parameter.estimate
    if not estimate.is_identifiable:
        return f"{symbol}: {value_text(estimate, unit)}"
    return f"{symbol} = {value_text(estimate, unit)} {unit.name}".rstrip()
