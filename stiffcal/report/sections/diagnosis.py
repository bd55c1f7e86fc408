"""The answer of the diagnosis: good enough, what is missing, and what a remainder follows."""

from __future__ import annotations

from functools import partial

from stiffcal.diagnosis.results import CompliancePattern, DiagnoseResult, LookAlike, ProposedEffect
from stiffcal.diagnosis.words import pattern_in_words, what_is_followed
from stiffcal.measurements.rms import VarianceRatio
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Facts,
    Items,
    LeftOut,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.pattern import draw_pattern

ORDER = 72
_TITLE = "What is missing"


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the answer first, then what it rests on."""
    diagnosis = content.diagnose
    if diagnosis is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    blocks: list[Block] = [Paragraph(diagnosis.summary, "key")]
    if content.states is not None:
        blocks.append(Paragraph(_meaning(diagnosis)))
    missing = diagnosis.missing
    if missing:
        blocks.append(Items(tuple(_missing_words(effect) for effect in missing)))
    blocks.append(Facts(tuple(_facts(diagnosis))))
    if diagnosis.structure:
        blocks.extend(_remainder(diagnosis))
    if diagnosis.pattern is not None:
        blocks.extend(_pattern(diagnosis.pattern))
    if diagnosis.superfluous:
        names = wording.listing(map(wording.effect_at, diagnosis.superfluous))
        its = "it" if len(diagnosis.superfluous) == 1 else "any of them"
        blocks.append(Paragraph(f"Not needed: {names}. Without {its} the error in held-out poses is no larger."))
    blocks.extend(_way_here(content))
    return ReportSection(_TITLE, tuple(blocks))


def _meaning(diagnosis: DiagnoseResult) -> str:
    """Describe the consequences of the result for the next step."""
    n = diagnosis.n_candidates
    tried = f"{wording.count(n, 'effect')} at their places were tried on top of the present model, " if n else ""
    tried += "everything else fitted again with each, judged in held-out poses."
    text = f"{tried[:1].upper()}{tried[1:]} "
    if diagnosis.adequate is None and diagnosis.unexplained:
        return text + (
            "How much of what is left is noise is not known: no load was repeated, and no uncertainty stated. That "
            "something is missing shows in what the remainder depends on."
        )
    if diagnosis.adequate is None:
        return text + "Whether what is left is noise cannot be judged: no load was repeated, and no uncertainty stated."
    if diagnosis.adequate:
        return text + (
            "No effect lowers the error by more than chance would. What is left scatters like the instruments and the "
            "setting of loads; a better model needs better instruments first."
        )
    if diagnosis.could_be:
        names = wording.listing(map(wording.effect_at, diagnosis.could_be), 40)
        return text + (
            "The error is larger than the noise. In these poses and loads the following look alike, each of them able "
            f"to make all of it: {names}. More poses, or loads along other axes in these, distinguish them."
        )
    if diagnosis.unexplained:
        words = "beyond what is named here " if diagnosis.missing else ""
        return text + (
            f"The error is larger than the noise, and {words}no effect of the catalogue, nor several together, brings "
            "it down to it. No effect is named; what the remainder depends on is listed below."
        )
    return text + "With what is named here the error falls to the noise:"


def _missing_words(effect: ProposedEffect) -> str:
    names = [_look_alike_words(alternative) for alternative in effect.alternatives]
    alike = f"; in these poses and loads {wording.listing(names, 6)} would look the same" if names else ""
    return f"{wording.effect_at(effect)}{alike}"


def _look_alike_words(effect: LookAlike) -> str:
    alike = "" if effect.cosine is None else f" with a cosine of {effect.cosine:.3f}"
    return f"{wording.effect_at(effect)}{alike}"


def _facts(diagnosis: DiagnoseResult) -> list[tuple[str, str]]:
    facts = [("present model", f"{wording.measure_text(diagnosis.rms)} rms in held-out poses")]
    if diagnosis.missing:
        after = diagnosis.heldout_rms_with_missing
        facts.append(("with what is missing", f"{wording.measure_text(after)} rms in held-out poses"))
    noise = wording.measure_text(diagnosis.noise) + " rms" if diagnosis.noise else "not known"
    facts.append(("noise", noise))
    lack = diagnosis.lack_of_fit
    if lack is not None:
        facts.append(("lack of fit", _lack_of_fit_words(lack)))
    explained = diagnosis.explained_by_missing
    if explained is not None and diagnosis.missing and diagnosis.noise:
        facts.append(("explained", f"{wording.percent(explained)} of the avoidable error is explained by it"))
    return facts


def _lack_of_fit_words(lack: VarianceRatio) -> str:
    own, of_repeats = lack.dof
    dof = f"{wording.digits(own)} and {wording.digits(of_repeats) if of_repeats else '∞'} degrees of freedom"
    negligible = lack.p_value is not None and lack.p_value < 1e-12
    chance = "p below 10⁻¹²" if negligible else f"p = {wording.digits(lack.p_value, 2)}"
    return f"F = {wording.digits(lack.statistic)} with {dof}, {chance}"


def _remainder(diagnosis: DiagnoseResult) -> list[Block]:
    columns = (
        TableColumn("follows", align="left"), TableColumn("share", "of what is left"),
        TableColumn("observation", align="left", width=1.0),
    )  # fmt: skip
    rows = tuple(
        (dependence.follows, wording.percent(dependence.share), dependence.seen) for dependence in diagnosis.structure
    )
    caption = (
        "What the remainder follows: the share of its squares beyond noise that smooth curves over each of these take "
        "away. Shares overlap; start with the largest."
    )
    return [SubheadingBlock("What the remainder follows"), TableBlock(columns, rows, caption)]


def _pattern(pattern: CompliancePattern) -> list[Block]:
    """Lay out whose compliance varies with what, run by run."""
    text = f"Where to look: {pattern_in_words(pattern)}."
    if pattern.alternatives:
        others = wording.listing(map(pattern_in_words, pattern.alternatives))
        text += f" These runs do not distinguish it from: {others}."
    text += " “stiffcal effects new NAME --from DIR” writes an effect that tests it."
    before, after = (
        wording.measure_text(pattern.heldout_rms_before),
        wording.measure_text(pattern.heldout_rms_after),
    )
    caption = (
        f"Each run’s apparent change of the compliance of joint {pattern.joint} against the "
        f"{what_is_followed(pattern)}, with 95 % bars, and the fitted law (line). In held-out poses the law takes the "
        f"error from {before} to {after} rms."
    )
    return [
        SubheadingBlock("A compliance that varies"),
        Paragraph(text),
        PictureBlock(partial(draw_pattern, pattern), caption),
    ]


def _way_here(content: ReportContent) -> list[Block]:
    """Name the earlier diagnoses that made the model what it is."""
    if not content.earlier_diagnoses:
        return []
    points = tuple(f"Fit {earlier.fit_id}: {earlier.summary}" for earlier in content.earlier_diagnoses)
    return [SubheadingBlock("How the model came to this"), Items(points)]
