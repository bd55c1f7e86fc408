"""The evidence, effect by effect: the residual against what drives it, before and after."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, LeftOut, Paragraph, Picture, ReportSection, Subheading
from stiffcal.report.content import EvidenceFigure, ReportContent
from stiffcal.report.figures.evidence import MOST_POINTS, draw_errors_by_run, draw_evidence

ORDER = 74
_TITLE = "The evidence, effect by effect"
# A chart with more runs than this has marks too close to tell.
_MOST_RUNS = 60


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out what speaks for each effect that is missing, or that the model gained."""
    if content.diagnose is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    if not content.evidence:
        reason = "nothing is missing, and the model holds no effect beyond the joints’ compliances"
        if content.diagnose.get("unexplained"):
            reason = "no effect accounts for what is left, so none is shown"
        return LeftOut(_TITLE, reason)
    blocks: list[Block] = [
        Paragraph(
            "Every effect is judged alone: the model without it is fitted again, everything else free, and both models "
            "predict each pose from the others only. The residual is read along the direction in which the effect "
            "moves the target. An effect that is real leaves its trace in the left picture and none in the middle one."
        )
    ]
    for one in content.evidence:
        blocks.extend(_of_one(content, one))
    return ReportSection(_TITLE, tuple(blocks))


def _of_one(content: ReportContent, one: EvidenceFigure) -> list[Block]:
    status = "missing" if one.missing else "in the model"
    blocks: list[Block] = [Subheading(f"{one.effect}, {wording.place(one.where)} ({status})")]
    text = one.seen or f"{_capital(one.fingerprint or one.summary)}."
    blocks.append(Paragraph(f"{text} {_rms_reduction_words(one)}"))
    facts = [("what it is", _capital(one.summary) + ".")]
    if one.parameters:
        facts.append(("as fitted", "; ".join(_parameter_words(each) for each in one.parameters)))
    if one.seen:
        names = [f"{each['effect']} ({wording.place(each['where'])})" for each in one.alternatives]
        facts.append(("looks the same", wording.listing(names, 6) if names else "nothing else in the catalogue"))
    if one.check:
        facts.append(("to check", one.check))
    blocks.append(Facts(tuple(facts)))
    blocks.append(Picture(partial(draw_evidence, one), _caption(one)))
    if 1 < len(one.by_run) <= _MOST_RUNS:
        component = "rotation" if one.rotational else "translation"
        noise = wording.part((content.diagnose or {}).get("noise"), component)
        better = sum(after < before for _, before, after in one.by_run)
        caption = f"Error run by run without and with {one.effect}: it falls in {better} of {len(one.by_run)} runs."
        blocks.append(Picture(partial(draw_errors_by_run, one, noise), caption))
    return blocks


def _rms_reduction_words(one: EvidenceFigure) -> str:
    if one.missing:
        left, after = wording.both(one.rms_before), wording.both(one.rms_after)
        return f"In unseen poses {left} rms is left without it, {after} with it."
    return (
        f"The present model leaves {wording.both(one.rms_after)} rms in unseen poses; without {one.effect} it would "
        f"leave {wording.both(one.rms_before)}."
    )


def _caption(one: EvidenceFigure) -> str:
    text = (
        f"Residual in unseen poses against {one.covariate}, without {one.effect} (left) and with it (middle), "
        "one scale."
    )
    if one.lever is not None:
        where = wording.place(one.where)
        text += (
            f" Each state’s residual is turned into the motion at {where} that it amounts to, times the mean lever "
            f"of {wording.digits(one.lever)} m."
        )
    n_known, n_all = int(np.isfinite(one.before).sum()), len(one.before)
    if n_known < n_all:
        why = "next to nothing of it shows there" if one.lever is None else "no lever"
        text += f" {n_all - n_known} of {n_all} states are not drawn: {why}."
    if n_known > MOST_POINTS:
        text += f" About {MOST_POINTS} states are drawn, the largest residuals among them."
    if one.path_run:
        text += f" The line follows run {one.path_run} from state to state; the other runs are grey."
    if one.picture is not None:
        text += f" Right: {one.picture.caption[0].lower()}{one.picture.caption[1:]}"
    return text


def _parameter_words(each: dict[str, object]) -> str:
    value, std = each.get("value"), each.get("std")
    symbol = str(each["name"]).rpartition(".")[2]
    unit = wording.unit_words(str(each.get("unit", "")))
    words = f"{symbol} = {wording.digits(float(str(value))) if value is not None else wording.DASH}"
    if std is not None:
        words += f" ± {wording.digits(float(str(std)), 2)}"
    return words if unit in ("", "1") else f"{words} {unit}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
