"""Acceptance: every limit of [thresholds] with its value, passed or failed. On request, `[report]` in campaign.toml."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import ANGLE, LENGTH, SHARE, STIFFNESS, Quantity, quantity_of
from stiffcal.report import wording
from stiffcal.report.blocks import LeftOut, Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent

if TYPE_CHECKING:
    from stiffcal.validation.results import ThresholdCheck

ORDER, IN_SHORT = 14, True
_TITLE = "Acceptance"

# Each limit's name, and what it is of.
_LIMITS: dict[str, tuple[str, Quantity]] = {
    "max_rms_m": ("position error in held-out data (rms), at most", LENGTH),
    "max_rms_rad": ("orientation error in held-out data (rms), at most", ANGLE),
    "max_relative": ("error in held-out data over deflection, at most", SHARE),
    "max_over_noise": ("error in held-out data over noise, at most", quantity_of("1")),
    "min_stiffness": ("stiffness, at least", STIFFNESS),
}


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out the verdict and a table of all limits."""
    if not content.settings.acceptance:
        return None
    checks = [] if content.validate is None else content.validate.checks
    if not checks:
        return LeftOut(_TITLE, "campaign.toml has no limits in [thresholds]")
    failed = sum(check.held is False for check in checks)
    open_checks = sum(check.held is None for check in checks)
    if failed:
        verdict = f"Failed: {failed} of {len(checks)} limits."
    elif open_checks:
        verdict = f"Not accepted: {open_checks} of {len(checks)} limits cannot be judged, the others passed."
    else:
        verdict = f"Passed: all {len(checks)} limits."
    columns = (
        TableColumn("quantity", align="left", width=1.0),
        TableColumn("joint", align="left"),
        TableColumn("limit"),
        TableColumn("value"),
        TableColumn("unit", align="left"),
        TableColumn("result", align="left"),
    )
    rows = tuple(_row(check) for check in checks)
    caption = "Limits of campaign.toml, [thresholds], and the values of this campaign."
    return ReportSection(_TITLE, (Paragraph(verdict, "key"), TableBlock(columns, rows, caption)))


def _row(check: ThresholdCheck) -> tuple[str, ...]:
    name, quantity = _LIMITS.get(check.threshold, (check.threshold, quantity_of(check.unit)))
    unit = quantity.unit_for([check.limit, check.value])
    value = "not known" if check.value is None else wording.significant(check.value * unit.factor)
    result = {True: "passed", False: "FAILED", None: "not judged"}[check.held]
    return name, check.where, wording.significant(check.limit * unit.factor), value, unit.name, result
