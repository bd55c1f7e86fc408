"""Lines for those who sign the report. On request, `[report]` in campaign.toml."""

from __future__ import annotations

from stiffcal.report.blocks import ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent

ORDER, IN_SHORT = 980, True
_TITLE = "Sign-off"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out one line for each role."""
    roles = content.settings.sign_off
    if not roles:
        return None
    columns = (
        TableColumn("role", align="left", width=1.2),
        TableColumn("name", align="left", width=1.5),
        TableColumn("date", align="left", width=1.0),
        TableColumn("signature", align="left", width=2.0),
    )
    # An empty line below each role leaves the height for a signature.
    rows = tuple((f"{role}\n\n", "", "", "") for role in roles)
    return ReportSection(_TITLE, (TableBlock(columns, rows, "Signatures."),))
