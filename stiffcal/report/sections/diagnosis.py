"""The answer of the diagnosis: good enough, what is missing, and what a remainder follows."""

from __future__ import annotations

from functools import partial

from stiffcal.diagnosis.answers.pattern_results import CompliancePattern
from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.diagnosis.words import pattern_in_words, what_is_followed
from stiffcal.judgement.numbers import NAMED
from stiffcal.measurements.rms import Rms, VarianceRatio
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
)
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.pattern import draw_pattern
from stiffcal.report.page_blocks import block_of
from stiffcal.show.answers.diagnose import add_in_model, add_missing, add_rest, law_picture
from stiffcal.show.builder import PageBuilder
from stiffcal.show.options import ShowOptions
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import explained_in_words, probability_in_words

ORDER = 72
_TITLE = "Missing effects"


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the answer first, then what it rests on."""
    diagnosis = content.diagnose
    if diagnosis is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    blocks: list[Block] = [Paragraph(diagnosis.summary, "key")]
    if content.states is not None:
        blocks.append(Paragraph(_meaning(diagnosis)))
    missing = PageBuilder(_TITLE)
    for effect in diagnosis.missing:
        add_missing(missing, diagnosis, effect)
    add_in_model(missing, diagnosis)
    blocks += map(block_of, missing.page().blocks)
    blocks.append(Facts(tuple(_facts(diagnosis))))
    rest = PageBuilder(_TITLE)
    add_rest(rest, diagnosis, ShowOptions(details=True))
    if diagnosis.pattern is None and (law := law_picture(diagnosis)) is not None:
        rest.draw(law)
    blocks += map(block_of, rest.page().blocks)
    if diagnosis.pattern is not None:
        blocks.extend(_pattern(diagnosis.pattern))
    blocks.extend(_way_here(content))
    return ReportSection(_TITLE, tuple(blocks))


def _meaning(diagnosis: DiagnoseResult) -> str:
    """Describe the consequences of the result for the next step."""
    n = diagnosis.n_candidates
    tried = f"{wording.count(n, 'effect')} at their places were added to the present model one by one, " if n else ""
    tried += f"with all other parameters refitted, and validated in {held_out_by_diagnosis(diagnosis.rms)}."
    text = f"{tried[:1].upper()}{tried[1:]} "
    if diagnosis.adequate is None and diagnosis.unexplained:
        return text + (
            "The share of noise in the remaining error is unknown: nothing was repeated, and no uncertainty stated. It "
            "depends on the variables below, so an effect is missing."
        )
    if diagnosis.adequate is None:
        return text + (
            "It cannot be judged whether the remaining error is noise: nothing was repeated, and no "
            "uncertainty is stated."
        )
    if diagnosis.adequate:
        return text + (
            "None of them is probably missing. The remaining error is the repeatability of the instruments "
            "and of the load application; a better model requires better instruments."
        )
    if diagnosis.could_be:
        names = wording.listing(map(wording.effect_at, diagnosis.could_be), 40)
        return text + (
            "The error is larger than the noise. In these poses and loads the following cannot be distinguished; each "
            f"of them alone explains it: {names}. More poses, or loads along other axes, would distinguish them."
        )
    if diagnosis.unexplained:
        words = "apart from the effects named here " if diagnosis.missing else ""
        return text + (
            f"The error is larger than the noise, and {words}no effect of the catalogue, alone or combined, reduces "
            f"it to the noise. {_on_what_it_depends(diagnosis)}"
        )
    return text + "With the effects named here the error decreases to the noise:"


def _on_what_it_depends(diagnosis: DiagnoseResult) -> str:
    if diagnosis.structure:
        return "No effect is named; the variables on which the remaining error depends are listed below."
    if law := probable_law(diagnosis):
        return f"No effect is named; what is left is probably {law}."
    return "No effect is named, and the remaining error follows none of the variables that were tried."


def probable_law(diagnosis: DiagnoseResult) -> str:
    """Return the law that no effect describes and is more probable than not, in words; "" where there is none."""
    law = next(iter(diagnosis.unknown or ()), None)
    if law is None or law.probability < NAMED:
        return ""
    return f"a law of {law.of} that no effect describes, of {law.follows} ({probability_in_words(law.probability)})"


def _facts(diagnosis: DiagnoseResult) -> list[tuple[str, str]]:
    validated, left_out = diagnosis.as_validated, held_out_by_diagnosis(diagnosis.rms)
    facts = [("present model", f"{wording.measure_text(diagnosis.rms)} rms in {left_out}")]
    if validated is not None:
        facts[0] = (facts[0][0], f"{facts[0][1]}, {_as_validated(validated.rms, validated.scheme)}")
    if diagnosis.missing:
        text = f"{wording.measure_text(diagnosis.heldout_rms_with_missing)} rms in {left_out}"
        if validated is not None and validated.with_missing is not None:
            text += f", {_as_validated(validated.with_missing, validated.scheme)}"
        facts.append(("with the missing effects", text))
    noise = wording.measure_text(diagnosis.noise) + " rms" if diagnosis.noise else "not known"
    facts.append(("noise", noise))
    lack = diagnosis.lack_of_fit
    if lack is not None:
        facts.append(("lack of fit", _lack_of_fit_words(lack)))
    explained = diagnosis.explained_by_missing
    if explained is not None and diagnosis.missing and diagnosis.noise:
        facts.append(("explained", f"{explained_in_words(explained)} of the avoidable error"))
    if diagnosis.not_weighed is not None:
        text = "sets with one effect more than those compared: about "
        facts.append(("not compared", f"{text}{wording.share(diagnosis.not_weighed)} of the probability"))
    return facts


def _as_validated(rms: Rms, scheme: str) -> str:
    return f"{wording.measure_text(rms)} in {held_out(scheme)}"


def _lack_of_fit_words(lack: VarianceRatio) -> str:
    own, of_repeats = lack.dof
    dof = f"{wording.significant(own)} and {wording.significant(of_repeats) if of_repeats else '∞'} degrees of freedom"
    negligible = lack.p_value is not None and lack.p_value < 1e-12
    chance = "p below 10⁻¹²" if negligible else f"p = {wording.significant(lack.p_value, 2)}"
    return f"F = {wording.significant(lack.statistic)} with {dof}, {chance}"


def _pattern(pattern: CompliancePattern) -> list[Block]:
    """Lay out whose compliance varies with what, run by run."""
    text = f"Probable location: {pattern_in_words(pattern)}."
    if pattern.alternatives:
        others = wording.listing(map(pattern_in_words, pattern.alternatives))
        text += f" In these runs it cannot be distinguished from: {others}."
    text += " “stiffcal effects new NAME --from DIR” writes an effect that tests it."
    before, after = (
        wording.measure_text(pattern.heldout_rms_before),
        wording.measure_text(pattern.heldout_rms_after),
    )
    caption = (
        f"Apparent change of the compliance of joint {pattern.joint} against the "
        f"{what_is_followed(pattern)}, with 95 % bars, and the fitted law (line). In held-out poses the law reduces "
        f"the error from {before} to {after} rms."
    )
    return [
        SubheadingBlock("Varying compliance"),
        Paragraph(text),
        PictureBlock(partial(draw_pattern, pattern), caption),
    ]


def _way_here(content: ReportContent) -> list[Block]:
    """Name the earlier diagnoses that made the model what it is."""
    if not content.earlier_diagnoses:
        return []
    points = tuple(f"Fit {earlier.fit_id}: {earlier.summary}" for earlier in content.earlier_diagnoses)
    return [SubheadingBlock("Earlier diagnoses"), Items(points)]
