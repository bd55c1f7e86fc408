"""Acceptance: every limit of [thresholds] with its value, passed or failed. On request, `[report]` in campaign.toml."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.report import wording
from stiffcal.report.blocks import LeftOut, Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent

if TYPE_CHECKING:
    from stiffcal.validation.results import ThresholdCheck

ORDER, IN_SHORT = 14, True
_TITLE = "Acceptance"

# Each limit's quantity, the factor to the unit in which people read it, and that unit.
_QUANTITIES = {
    "max_rms_m": ("position error in held-out data (rms), at most", 1e3, "mm"),
    "max_rms_rad": ("orientation error in held-out data (rms), at most", 1e3, "mrad"),
    "max_relative": ("error in held-out data over deflection, at most", 1e2, "%"),
    "max_over_noise": ("error in held-out data over noise, at most", 1.0, ""),
    "min_stiffness": ("stiffness, at least", 1.0, "N·m/rad"),
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
    name, factor, unit = _QUANTITIES.get(check.threshold, (check.threshold, 1.0, check.unit))
    value = "not known" if check.value is None else wording.significant(check.value * factor)
    result = {True: "passed", False: "FAILED", None: "not judged"}[check.held]
    return name, check.where, wording.significant(check.limit * factor), value, unit, result
