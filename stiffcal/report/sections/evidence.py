"""The evidence, effect by effect: the residual against what drives it, before and after."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.diagnosis.results import DiagnoseResult, EffectEvidenceSummary
from stiffcal.identification.fit_results import IdentifiedParameter
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, LeftOut, Paragraph, PictureBlock, ReportSection, SubheadingBlock
from stiffcal.report.content import EvidenceFigure, ReportContent
from stiffcal.report.figures.evidence import MOST_POINTS, draw_errors_by_run, draw_evidence

ORDER = 74
_TITLE = "The evidence, effect by effect"
# A chart with more runs than this has marks too close to distinguish.
_MOST_RUNS = 60


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the evidence for each effect that is missing, or that the model gained."""
    if content.diagnose is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    if not content.evidence:
        reason = "the diagnosis kept no evidence of single effects"
        if not content.diagnose.has_searched:
            reason = "there are no load states in which effects could be judged"
        elif not content.diagnose.missing:
            reason = (
                "no effect on load states is missing, and the model holds none beyond the joints’ compliances that is "
                "judged alone"
            )
        if content.diagnose.unexplained:
            reason = "no effect accounts for what is left, so none is shown"
        return LeftOut(_TITLE, reason)
    blocks: list[Block] = [
        Paragraph(
            "Every effect is judged alone: the model without it is fitted again, everything else free, and both models "
            "predict each pose from the others only. The residual is read along the direction in which the effect "
            "moves the target. An effect that is real leaves its trace in the left picture and none in the middle one."
        )
    ]
    for figure in content.evidence:
        blocks.extend(_of_effect(content.diagnose, figure))
    return ReportSection(_TITLE, tuple(blocks))


def _of_effect(diagnosis: DiagnoseResult, figure: EvidenceFigure) -> list[Block]:
    evidence = figure.evidence
    blocks: list[Block] = [SubheadingBlock(f"{evidence.effect}, {wording.place(evidence.where)} ({evidence.status})")]
    text = figure.seen or f"{_capital(figure.fingerprint or figure.summary)}."
    blocks.append(Paragraph(f"{text} {_rms_reduction_words(evidence)}"))
    facts = [("what it is", _capital(figure.summary) + ".")]
    if figure.parameters:
        facts.append(("as fitted", "; ".join(_parameter_words(parameter) for parameter in figure.parameters)))
    if figure.seen:
        names = [wording.effect_at(alternative) for alternative in figure.alternatives]
        facts.append(("looks the same", wording.listing(names, 6) if names else "nothing else in the catalogue"))
    if figure.check:
        facts.append(("to check", figure.check))
    blocks.append(Facts(tuple(facts)))
    blocks.append(PictureBlock(partial(draw_evidence, figure), _caption(figure)))
    if 1 < len(evidence.by_run) <= _MOST_RUNS:
        noise = wording.part(diagnosis.noise, evidence.component)
        better = sum(run.after < run.before for run in evidence.by_run)
        caption = (
            f"Error run by run without and with {evidence.effect}: it falls in {better} of {len(evidence.by_run)} runs."
        )
        blocks.append(PictureBlock(partial(draw_errors_by_run, figure, noise), caption))
    return blocks


def _rms_reduction_words(evidence: EffectEvidenceSummary) -> str:
    before, after = (
        wording.measure_text(evidence.heldout_rms_before),
        wording.measure_text(evidence.heldout_rms_after),
    )
    if evidence.status == "missing":
        return f"In held-out poses {before} rms is left without it, {after} with it."
    return f"The present model leaves {after} rms in held-out poses; without {evidence.effect} it would leave {before}."


def _caption(figure: EvidenceFigure) -> str:
    evidence = figure.evidence
    text = (
        f"Residual in held-out poses against {evidence.driver}, without {evidence.effect} (left) and with it (middle), "
        "one scale."
    )
    if evidence.lever is not None:
        where = wording.place(evidence.where)
        text += (
            f" Each state’s residual is turned into the motion at {where} that it amounts to, times the mean lever "
            f"of {wording.digits(evidence.lever)} m."
        )
    n_known, n_all = int(np.isfinite(figure.before).sum()), len(figure.before)
    if n_known < n_all:
        why = "next to nothing of it shows there" if evidence.lever is None else "no lever"
        text += f" {n_all - n_known} of {n_all} states are not drawn: {why}."
    if n_known > MOST_POINTS:
        text += f" About {MOST_POINTS} states are drawn, the largest residuals among them."
    if figure.path_run:
        text += f" The line follows run {figure.path_run} from state to state; the other runs are grey."
    if figure.picture is not None:
        text += f" Right: {figure.picture.caption[0].lower()}{figure.picture.caption[1:]}"
    return text


def _parameter_words(parameter: IdentifiedParameter) -> str:
    symbol, unit = parameter.name.rpartition(".")[2], wording.unit_words(parameter.unit)
    text = f"{symbol} = {wording.digits(parameter.value)}"
    if parameter.std is not None:
        text += f" ± {wording.digits(parameter.std, 2)}"
    return text if unit in ("", "1") else f"{text} {unit}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
