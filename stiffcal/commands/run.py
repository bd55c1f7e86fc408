"""Check to report in one go."""

from __future__ import annotations

from pathlib import Path

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.report import REPORT_FILE, report_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.commands.view import VIEW_FILE, view_campaign
from stiffcal.stages.run_result import RunResult
from stiffcal.stages.steps import RunContext
from stiffcal.trust.output_kinds import PAGE, REPORT
from stiffcal.trust.outputs import check_not_foreign


def run_campaign(folder: Path, context: RunContext | None = None) -> RunResult:
    """Run check, ingest, identify, validate, diagnose, report and view on a campaign.

    Returns
    -------
    RunResult
        The answers of all steps, the PDF, the page for a browser, and whether the thresholds hold.

    Raises
    ------
    InputError : the input is wrong.
    """
    from stiffcal.ingest.checks.loaded import check_campaign

    context = context or RunContext()
    for name, kind in ((REPORT_FILE, REPORT), (VIEW_FILE, PAGE)):
        check_not_foreign(Path(folder) / name, kind, context.overwrite)
    checked = check_campaign(folder, progress=context.progress)
    identified = identify_campaign(folder, context)
    validation = validate_campaign(folder, context)
    diagnosis = diagnose_campaign(folder, context)
    report = report_campaign(folder, context)
    page = view_campaign(folder, context)
    warnings = [*checked.warnings, *identified.warnings, *validation.warnings, *diagnosis.warnings, *page.warnings]
    return RunResult(
        warnings=list(dict.fromkeys(warnings)),
        check=checked,
        identify=identified,
        validate=validation,
        diagnose=diagnosis,
        report=report.file,
        view=page.file,
        passed=validation.passed,
    )
