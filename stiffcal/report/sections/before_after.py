"""What each effect that was added did to the identified values, and what adding what is missing would do."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.identification.answers.before_after import BeforeAfter, units_of_values
from stiffcal.quantity import Units
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Paragraph, ReportSection, SubheadingBlock, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.report.sections.stiffness import where_words
from stiffcal.results.value_words import value_in_model

ORDER = 35
_TITLE = "Stiffness before and after"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out, for each change of the model, the values that it moved out of their 95 % intervals."""
    blocks: list[Block] = []
    for change in content.fit_changes:
        own = "" if change.own else " (not computed by you)"
        blocks.append(SubheadingBlock(f"{change.change}: fit {change.before} → fit {change.after}{own}"))
        blocks += _values(change.values, content)
    diagnosis = content.diagnose
    if diagnosis is not None and diagnosis.before_after:
        names = wording.listing(wording.effect_at(effect) for effect in diagnosis.missing)
        blocks.append(SubheadingBlock(f"What adding {names} would change"))
        blocks += _values(diagnosis.before_after, content)
    if not blocks:
        return None
    return ReportSection(_TITLE, (Paragraph(_lead()), *blocks))


def _lead() -> str:
    return (
        "Change of the identified values by each change of the model. If the later model is correct, a value that "
        "changes by more than its 95 % interval had an error larger than its stated uncertainty."
    )


def _values(values: Sequence[BeforeAfter], content: ReportContent) -> list[Block]:
    """Return a table of what moved beyond its interval or is new, and how much of the rest stayed within."""
    listed = [value for value in values if value.outside_interval or value.before is None or value.after is None]
    listed.sort(key=lambda value: (not value.outside_interval, -abs(value.relative or 0.0)))
    n_within = sum(not value.outside_interval for value in values if value.before and value.after)
    within = f"{wording.count(n_within, 'other value')} stay{'s' * (n_within == 1)} within the 95 % interval."
    if not listed:
        return [Paragraph(f"No value changed by more than its 95 % interval ({n_within} compared).")]
    columns = (
        TableColumn("place", align="left"), TableColumn("effect", align="left", width=1.0),
        TableColumn("before"), TableColumn("after"), TableColumn("unit", align="left"),
        TableColumn("change"),
    )  # fmt: skip
    units = units_of_values(listed)
    rows = tuple(_row(value, content, units) for value in listed)
    caption = (
        "Values, ± 95 %, that changed by more than their 95 % interval, and values that only one of the two models "
        "contains."
    )
    return [TableBlock(columns, rows, f"{caption} {within}" if n_within else caption)]


def _row(value: BeforeAfter, content: ReportContent, units: Units) -> tuple[str, ...]:
    symbol = value.name.rsplit(".", 1)[-1]
    unit = units.of(value.quantity)
    change = wording.DASH
    if value.relative is not None:
        sign = "+" if value.relative > 0 else ""
        change = f"{sign}{wording.share(value.relative)}"
    return (
        value.setup_part or where_words(value.where, content.joint_names),
        value.effect + ("" if symbol == "c" else f", {symbol}"),
        value_in_model(value.before, unit), value_in_model(value.after, unit), unit.name, change,
    )  # fmt: skip
