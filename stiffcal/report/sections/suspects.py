"""Runs and rows that disagree with all the others, with the lines that leave them out."""

from __future__ import annotations

from stiffcal.diagnosis.answers.suspect_results import Suspect
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Facts,
    Paragraph,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent
from stiffcal.wording import probability_in_words

ORDER = 12
_TITLE = "Runs that disagree with the others"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out each suspect with its cause and cure; nothing where all runs agree."""
    answer = content.diagnose or content.identify
    if answer is None:
        return None
    suspects, not_checked = answer.suspects or [], answer.suspects_not_checked
    if not suspects:
        return None
    runs = wording.listing([_place(suspect) for suspect in suspects], 12)
    searched = content.diagnose is not None and any(suspect.is_left_out for suspect in suspects)
    but = ", the search for missing effects leaves them out" if searched else ""
    blocks: list[Block] = [Paragraph(f"Check these first: {runs}. The fit includes them{but}.", "key")]
    for suspect in suspects:
        blocks += [SubheadingBlock(_place(suspect)), Facts(tuple(_facts(suspect)))]
    lines = tuple((line,) for suspect in suspects for line in suspect.exclude)
    column = TableColumn("to exclude them, add to campaign.toml", align="left", width=1.0, mono=True)
    blocks.append(TableBlock((column,), lines, "Lines that exclude these runs or rows from the fit."))
    if not_checked is not None:
        blocks.append(Paragraph(f"{not_checked.sentence[:1].upper()}{not_checked.sentence[1:]}."))
    return ReportSection(_TITLE, tuple(blocks))


def _place(suspect: Suspect) -> str:
    return f"run {suspect.run}" if suspect.row is None else f"run {suspect.run}, row {suspect.row}"


def _facts(suspect: Suspect) -> list[tuple[str, str]]:
    facts = [("kind", str(suspect.kind)), ("finding", suspect.why), ("likely", suspect.likely)]
    if suspect.probability is not None:
        facts.append(("probability", probability_in_words(suspect.probability)))
    if suspect.explained_by:
        effects = wording.listing(map(wording.effect_at, suspect.explained_by))
        facts.append(("equally well explained by", effects))
    without = suspect.without
    if without is not None:
        facts.append(("without this run", f"residual of the fit {wording.measure_text(without.rms)} rms"))
    return facts
