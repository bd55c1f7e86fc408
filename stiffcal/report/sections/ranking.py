"""The ranking: every effect that was tried, best first, with verdict, error, probability and look-alikes."""

from __future__ import annotations

from stiffcal.diagnosis.answers.results import DiagnoseResult, EarlierDiagnosis, Finding, supported_but_not_named
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    LeftOut,
    Paragraph,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent
from stiffcal.wording import explained_in_words, probability_in_words

ORDER = 910
_TITLE = "Appendix: all effects that were tried"
_MOST_ROWS = 15
# Where every candidate is rejected, the first few are enough.
_FEW_ROWS = 8
_MOST_ALIKE = 1
_COLUMNS = (
    TableColumn("effect", align="left"),
    TableColumn("place", align="left"),
    TableColumn("verdict", align="left"),
    TableColumn("held-out,\nrms"),
    TableColumn("explains"),
    TableColumn("probability"),
    TableColumn("size"),
    TableColumn("p"),
    TableColumn("look-alikes", align="left", width=1.0),
)


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the ranking of additions to the present model, those of the earlier steps, and what was not tried."""
    diagnosis = content.diagnose
    if diagnosis is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    if content.states is None and not diagnosis.findings:
        return LeftOut(_TITLE, "without load states no effect was tried")
    blocks: list[Block] = []
    if content.earlier_diagnoses:
        blocks.append(SubheadingBlock("On top of the present model"))
    blocks.append(_table(diagnosis, _MOST_ROWS))
    blocks.append(Paragraph(_explanation_of_columns(diagnosis), "quiet"))
    for earlier in content.earlier_diagnoses:
        blocks.append(SubheadingBlock(f"On top of fit {earlier.fit_id}, before {_missing_in_words(earlier)} was added"))
        blocks.append(_table(earlier, len(earlier.findings)))
    if diagnosis.not_tried:
        blocks.append(Paragraph(f"Not tried: {'; '.join(_not_tried(diagnosis))}.", "quiet"))
    return ReportSection(_TITLE, tuple(blocks))


def _not_tried(diagnosis: DiagnoseResult) -> tuple[str, ...]:
    """Return what effects that were not tried need, each need once with all of its effects."""
    of_need: dict[str, list[str]] = {}
    for effect in diagnosis.not_tried:
        of_need.setdefault(effect.needs, []).append(effect.effect)
    return tuple(f"{wording.listing(names, 24)} (needs {needs})" for needs, names in of_need.items())


def _missing_in_words(diagnosis: EarlierDiagnosis) -> str:
    return wording.listing(map(wording.effect_at, diagnosis.missing))


def _table(diagnosis: DiagnoseResult | EarlierDiagnosis, most: int) -> TableBlock:
    rows: list[tuple[str, ...]] = [("present model", "", "", wording.measure_cell(diagnosis.rms), "", "", "", "", "")]
    findings = diagnosis.findings
    if not any(finding.verdict != "rejected" for finding in findings):
        most = min(most, _FEW_ROWS)
    rows += [_row(diagnosis, finding) for finding in findings[:most]]
    noise = wording.measure_cell(diagnosis.noise) if diagnosis.noise else "not known"
    rows.append(("noise", "", "", noise, "", "", "", "", ""))
    caption = "Ranking for the next single step, best first: each row adds one effect to the present model."
    later = [
        wording.effect_at(effect) for effect in diagnosis.missing
        if (finding := diagnosis.finding_of(effect)) is None or finding.verdict != "supported"
    ]  # fmt: skip
    if later and len(later) < len(diagnosis.missing):
        caption += f" {wording.capital(wording.listing(later))} was found with the first in the model."
    if isinstance(diagnosis, DiagnoseResult) and (not_named := supported_but_not_named(diagnosis)) is not None:
        name = wording.capital(wording.effect_at(not_named))
        caption += f" {name} is significant and not named: the rest has no explanation."
    if len(findings) > most:
        caption += f" {len(findings) - most} more rank below; stiffcal diagnose --json lists them."
    columns = list(_COLUMNS)
    if not any(row[-1] for row in rows):
        plain = TableColumn("p", align="left", width=1.0)
        return TableBlock((*columns[:-2], plain), tuple(row[:-1] for row in rows), f"{caption} None has a look-alike.")
    return TableBlock(tuple(columns), tuple(rows), caption)


def _row(diagnosis: DiagnoseResult | EarlierDiagnosis, finding: Finding) -> tuple[str, ...]:
    alike = [wording.effect_at(alternative) for alternative in finding.alternatives]
    p = finding.p_value
    return (
        finding.effect,
        wording.place(finding.where),
        finding.verdict,
        wording.measure_cell(finding.heldout_rms_after),
        explained_in_words(
            diagnosis.explained_by(finding) if isinstance(diagnosis, DiagnoseResult) else finding.explains
        ),
        probability_in_words(finding.probability or 0.0),
        wording.size_of_effect(finding.size_m, finding.size_Nm),
        wording.DASH if p is None else "<\u00a010⁻⁶" if p < 1e-6 else wording.significant(p, 2),
        wording.listing(alike, _MOST_ALIKE) if alike else "",
    )


def _explanation_of_columns(diagnosis: DiagnoseResult) -> str:
    """Return the text that explains the columns of the ranking."""
    text = (
        "Held-out: error with the effect added, in data that were left out of the fit in turn. Explains: share of the "
        "avoidable error (above the "
        "noise) that is removed, of what alone is missing by the refitted model, of all others by a first estimate. "
        "Size: rms contribution of the effect at the tool, or in the torque. p: probability of an equal decrease by "
        "chance, allowing for the number of candidates. Probability: that the effect is there, next to all other "
        "effects, mistakes in the data and laws of no catalogue. Supported: named; possible: 5 % and more."
    )
    chosen = next(
        (finding.heldout_rms_after_choosing for finding in diagnosis.findings if finding.heldout_rms_after_choosing),
        None,
    )
    if chosen is not None:
        text += (
            f" With the selection repeated without each pose the error is "
            f"{wording.measure_text(chosen)} rms: selection bias is included in this figure."
        )
    return text
