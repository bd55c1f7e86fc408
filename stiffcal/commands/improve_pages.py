"""Page and report of a model that `improve` has changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.commands.report import REPORT_FILE, report_campaign
from stiffcal.commands.view import VIEW_FILE, view_campaign
from stiffcal.errors import InputError
from stiffcal.trust.output_kinds import PAGE, REPORT, OutputKind
from stiffcal.trust.outputs import check_not_foreign

if TYPE_CHECKING:
    from stiffcal.results.improve_results import ImproveResult
    from stiffcal.stages.steps import RunContext


def check_pages(folder: Path, context: RunContext) -> None:
    """Refuse, before the work begins, where page or report would take the place of a file of somebody else's.

    Raises
    ------
    InputError : DIR/view.html or DIR/report.pdf holds something stiffcal did not write.
    """
    for name, kind in ((VIEW_FILE, PAGE), (REPORT_FILE, REPORT)):
        check_not_foreign(Path(folder) / name, kind, context.overwrite)


def with_pages(result: ImproveResult, folder: Path, context: RunContext) -> ImproveResult:
    """Write page and report anew where the model was changed; return the result with their names.

    What stiffcal did not write stays, with a warning.

    Parameters
    ----------
    result : of `improve_campaign`. folder, context : as they were given to it.

    Raises
    ------
    InputError : a file cannot be written.
    """
    if not result.changed:
        return result
    warnings = list(result.warnings)

    def is_free(name: str, kind: OutputKind) -> bool:
        try:
            check_not_foreign(Path(folder) / name, kind, context.overwrite)
        except InputError as error:
            fault = error.faults[0]
            warnings.append(f"{fault.file} is not written anew: {fault.reason}; {fault.mend}")
            return False
        return True

    page = view_campaign(folder, context) if is_free(VIEW_FILE, PAGE) else None
    report = report_campaign(folder, context) if is_free(REPORT_FILE, REPORT) else None
    for written in (page, report):
        warnings += written.warnings if written is not None else []
    return replace(
        result,
        warnings=list(dict.fromkeys(warnings)),
        view=None if page is None else page.file,
        report=None if report is None else report.file,
    )
