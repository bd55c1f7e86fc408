"""Whether the kinds of experiment of one campaign agree on the parameters that several determine."""

from __future__ import annotations

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.results.agreement_words import rows, runs_of_kinds, verdict

ORDER = 45
_TITLE = "Agreement between instruments"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out what each kind of experiment determines alone; nothing where the campaign holds one kind."""
    agreements = None if content.identify is None else content.identify.agreement
    if not agreements:
        return None
    blocks: list[Block] = []
    for agreement in agreements:
        first, second = runs_of_kinds(agreement)
        columns = (
            TableColumn("parameter", align="left", mono=True), TableColumn(f"{first} alone"),
            TableColumn(f"{second} alone"), TableColumn("unit", align="left"),
            TableColumn("difference", "standard errors"),
        )  # fmt: skip
        caption = f"The same model fitted to {first} alone and to {second} alone, ± 95 %."
        blocks += [
            Paragraph(f"{wording.capital(verdict(agreement))}."),
            TableBlock(columns, tuple(rows(agreement)), caption),
        ]
    return ReportSection(_TITLE, tuple(blocks))
