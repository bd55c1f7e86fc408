"""Check to report in one go."""

from __future__ import annotations

from pathlib import Path

from stiffcal.documents import document_of
from stiffcal.workflow.diagnose import diagnose_campaign
from stiffcal.workflow.identify import identify_campaign
from stiffcal.workflow.report import report_campaign
from stiffcal.workflow.steps import Document, RunContext
from stiffcal.workflow.validate import validate_campaign


def run_campaign(folder: Path, context: RunContext | None = None) -> Document:
    """Run check, ingest, identify, validate, diagnose and report on a campaign.

    Returns
    -------
    dict
        ``identify``, ``validate`` and ``diagnose`` documents, ``report`` (the PDF), ``passed`` (thresholds and check).

    Raises
    ------
    InputError : the input is wrong.
    """
    from stiffcal.workflow.check import check_campaign

    context = context or RunContext()
    checked = document_of(check_campaign(folder, progress=context.progress))
    identified = identify_campaign(folder, context)
    validation = validate_campaign(folder, context)
    diagnosis = document_of(diagnose_campaign(folder, context))
    report = report_campaign(folder, context)
    steps = (checked, identified, validation, diagnosis)
    return {
        "schema": "stiffcal/run/1",
        "warnings": list(dict.fromkeys(text for one in steps for text in one["warnings"])),
        "check": checked,
        "identify": identified,
        "validate": validation,
        "diagnose": diagnosis,
        "report": report.file,
        "passed": validation["passed"],
    }
