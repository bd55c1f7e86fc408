"""Check to report in one go."""

from __future__ import annotations

from pathlib import Path

from stiffcal.workflow.identify import identify_campaign
from stiffcal.workflow.report import report_campaign
from stiffcal.workflow.steps import Document, Means
from stiffcal.workflow.validate import validate_campaign


def run_campaign(folder: Path, means: Means | None = None) -> Document:
    """Run check, ingest, identify, validate and report on a campaign.

    Returns
    -------
    dict
        ``identify`` and ``validate`` documents, ``report`` (the PDF), ``passed`` (thresholds and check).

    Raises
    ------
    InputError : the input is wrong.
    """
    from stiffcal.workflow.check import check_campaign

    means = means or Means()
    checked = check_campaign(folder, progress=means.progress)
    identified = identify_campaign(folder, means)
    validation = validate_campaign(folder, means)
    report = report_campaign(folder, means)
    return {
        "schema": "stiffcal/run/1",
        "warnings": list(dict.fromkeys([*checked["warnings"], *identified["warnings"], *validation["warnings"]])),
        "check": checked,
        "identify": identified,
        "validate": validation,
        "report": report["file"],
        "passed": validation["passed"],
    }
