"""Appendix: the evidence for the effects that the model holds beyond the joints' compliances."""

from __future__ import annotations

from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import EvidenceFigure, ReportContent
from stiffcal.report.sections.evidence import HOW_JUDGED, evidence_of

ORDER = 900
_TITLE = "Appendix: evidence for effects in the model"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out the evidence for each effect in the model; those that are not needed in a table."""
    diagnosis = content.diagnose
    figures = [figure for figure in content.evidence if not figure.missing]
    if diagnosis is None or not figures:
        return None
    needed = [figure for figure in figures if not _is_superfluous(diagnosis, figure)]
    blocks: list[Block] = [Paragraph(HOW_JUDGED)]
    for figure in needed:
        blocks.extend(evidence_of(diagnosis, figure, by_run=False))
    unneeded = [figure for figure in figures if figure not in needed]
    if unneeded:
        blocks.append(_not_needed(unneeded))
    return ReportSection(_TITLE, tuple(blocks))


def _is_superfluous(diagnosis: DiagnoseResult, figure: EvidenceFigure) -> bool:
    evidence = figure.evidence
    return any(effect.effect == evidence.effect and effect.where == evidence.where for effect in diagnosis.superfluous)


def _not_needed(figures: list[EvidenceFigure]) -> TableBlock:
    columns = (
        TableColumn("effect", align="left"),
        TableColumn("place", align="left", width=1.0),
        TableColumn("error with it, rms"),
        TableColumn("error without it, rms"),
        TableColumn("runs in which\nit decreases"),
    )
    rows = []
    for figure in figures:
        evidence = figure.evidence
        better = sum(run.after < run.before for run in evidence.by_run)
        without, decreases = wording.measure_cell(evidence.heldout_rms_before), f"{better} of {len(evidence.by_run)}"
        # what the others can replace costs nothing; they are held at their values in the comparison by run
        if figure.parameters and not any(parameter.identifiable for parameter in figure.parameters):
            without, decreases = "as with it: not identifiable", wording.DASH
        rows.append(
            (evidence.effect, wording.place(evidence.where), wording.measure_cell(evidence.heldout_rms_after), without,
             decreases)
        )  # fmt: skip
    caption = "Effects that the model does not need: without them the error in held-out poses is no larger."
    return TableBlock(columns, tuple(rows), caption)
