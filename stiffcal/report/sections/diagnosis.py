"""The answer of the diagnosis: good enough, what is missing, and what a remainder follows."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from stiffcal.diagnosis.answers.pattern_results import CompliancePattern
from stiffcal.diagnosis.answers.results import (
    DiagnoseResult,
    ExcludedSizeAt,
    LawCurveAt,
    LookAlike,
    ProposedEffect,
    UnknownLaw,
)
from stiffcal.diagnosis.words import pattern_in_words, what_is_followed
from stiffcal.judgement.numbers import NAMED
from stiffcal.measurements.rms import Rms, VarianceRatio
from stiffcal.quantity import JOINT_ANGLE, quantity_of
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
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import explained_in_words, probability_in_words, variable

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
    missing = diagnosis.missing
    if missing:
        blocks.append(Items(tuple(_missing_words(effect) for effect in missing)))
    if diagnosis.in_model:
        held = tuple(f"In the model: {_missing_words(effect)}" for effect in diagnosis.in_model)
        blocks.append(Items(held))
    blocks.append(Facts(tuple(_facts(diagnosis))))
    if diagnosis.excluded_sizes and not diagnosis.unexplained:
        blocks.append(Paragraph(_excluded(diagnosis.excluded_sizes)))
    if diagnosis.structure:
        blocks.extend(_remainder(diagnosis))
    law = next(iter(diagnosis.unknown or ()), None)
    if diagnosis.pattern is not None:
        blocks.extend(_pattern(diagnosis.pattern))
    elif law is not None and law.curve is not None and diagnosis.unexplained:
        blocks.extend(_law(law, law.curve))
    if diagnosis.superfluous:
        names = wording.listing(map(wording.effect_at, diagnosis.superfluous))
        blocks.append(Paragraph(f"In the model and probably not there: {names}."))
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


def _excluded(sizes: Sequence[ExcludedSizeAt]) -> str:
    """Return how large an effect at each place would have been found, in words."""
    known = [one for one in sizes if one.size_m is not None or one.size_Nm is not None]
    known.sort(key=lambda one: (-(one.size_m or 0.0), -(one.size_Nm or 0.0)))
    hidden = [one.of for one in sizes if one not in known]
    text = ""
    if known:
        listed = wording.listing([f"{one.of} {wording.size_of_effect(one.size_m, one.size_Nm)}" for one in known], 30)
        text = (
            "In nine campaigns of ten like this one an effect of this size (rms at the tool, or of the torque) would "
        )
        text += f"be found: {listed}."
    if hidden:
        text += f" Nowhere in this campaign shows: {wording.listing(hidden, 30)}."
    forces = [
        f"{one.of} {wording.significant(one.deciding_force_N)} N" for one in known if one.deciding_force_N is not None
    ]
    if forces:
        text += f" Loads up to these would show what is as large as the noise: {wording.listing(forces, 30)}."
    return text.strip()


def _missing_words(effect: ProposedEffect) -> str:
    names = [_look_alike_words(effect, alternative) for alternative in effect.alternatives]
    alike = f"; cannot be distinguished in these poses and loads: {wording.listing(names, 6)}" if names else ""
    certain = "" if effect.firm else ", not certain"
    own = probability_in_words(effect.probability_of(effect) or 0.0)
    group = f"; one of them: {probability_in_words(effect.probability or 0.0)}" if names else ""
    return f"{wording.effect_at(effect)}: {own}{certain}{alike}{group}"


def _look_alike_words(of: ProposedEffect, effect: LookAlike) -> str:
    return f"{wording.effect_at(effect)} {probability_in_words(of.probability_of(effect) or 0.0)}"


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
        facts.append(("explained", f"{explained_in_words(explained)} of the avoidable error is explained by it"))
    if diagnosis.not_weighed is not None:
        text = (
            "combinations of those compared with one effect more, which have about "
            f"{wording.share(diagnosis.not_weighed)} of the probability"
        )
        facts.append(("not compared", text))
    return facts


def _as_validated(rms: Rms, scheme: str) -> str:
    return f"{wording.measure_text(rms)} in {held_out(scheme)}"


def _lack_of_fit_words(lack: VarianceRatio) -> str:
    own, of_repeats = lack.dof
    dof = f"{wording.significant(own)} and {wording.significant(of_repeats) if of_repeats else '∞'} degrees of freedom"
    negligible = lack.p_value is not None and lack.p_value < 1e-12
    chance = "p below 10⁻¹²" if negligible else f"p = {wording.significant(lack.p_value, 2)}"
    return f"F = {wording.significant(lack.statistic)} with {dof}, {chance}"


def _remainder(diagnosis: DiagnoseResult) -> list[Block]:
    columns = (
        TableColumn("variable", align="left"), TableColumn("share", "of the remaining error"),
        TableColumn("observation", align="left", width=1.0),
    )  # fmt: skip
    rows = tuple(
        (variable(dependence.follows).removeprefix("the "), wording.share(dependence.share), dependence.seen)
        for dependence in diagnosis.structure
    )
    caption = (
        "Variables on which the remaining error depends: share of its squares above the noise that a smooth curve over "
        "each variable explains. Shares overlap; start with the largest."
    )
    return [SubheadingBlock("Dependence of the remaining error"), TableBlock(columns, rows, caption)]


def _law(law: UnknownLaw, curve: LawCurveAt) -> list[Block]:
    """Lay out the curve of a law that no catalogue holds."""
    unit = quantity_of(curve.value_unit).unit_for(curve.value)
    over = (JOINT_ANGLE if curve.unit == "rad" else quantity_of(curve.unit)).unit_for(curve.at)
    what, _, joint = curve.over.partition(":")
    columns = (TableColumn(f"{what} of joint {joint}", over.name), TableColumn(f"law of {law.of}", unit.name))
    rows = tuple(
        (wording.significant(over.factor * at), wording.significant(unit.factor * value))
        for at, value in zip(curve.at, curve.value, strict=True)
    )
    caption = (
        f"Law of {law.of} that no effect of the catalogue describes, probability "
        f"{probability_in_words(law.probability)}: what it adds to the joint's give, at its most probable values."
    )
    return [SubheadingBlock("Law of its own"), TableBlock(columns, rows, caption)]


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
