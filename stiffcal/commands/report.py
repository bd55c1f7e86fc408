"""The PDF of a campaign."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from stiffcal.commands.history import read_history
from stiffcal.results.command_results import ReportResult
from stiffcal.stages.fit import up_to_date_fit_at_hand
from stiffcal.stages.steps import IDENTIFY, RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from stiffcal.trust.output_kinds import REPORT
from stiffcal.trust.outputs import chosen_output, written

REPORT_FILE = "report.pdf"


def report_campaign(
    folder: Path, context: RunContext | None = None, output: Path | None = None, is_short: bool = False
) -> ReportResult:
    """Write the report of a campaign.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    output : where to; default DIR/report.pdf. is_short : two pages for a customer.

    Returns
    -------
    ReportResult
        The PDF.

    Raises
    ------
    InputError : the input is wrong, the file's name does not end in .pdf, or it cannot be written or holds
        something stiffcal did not write.
    """
    context = context or RunContext()
    file = chosen_output(output, Path(folder) / REPORT_FILE, REPORT, context.overwrite)
    data = up_to_date_states(folder, context)
    identified, fit = up_to_date_fit_at_hand(data, context)
    validation = up_to_date_validation(data, identified, context, fit)

    from stiffcal.commands.report_requests import with_requests
    from stiffcal.report.building import build_report
    from stiffcal.report.gathering.content import report_content
    from stiffcal.report.gathering.plot_of_fit import CAPTIONS, pictures_of_fit
    from stiffcal.report.pictures_of_fit import PictureOfFit

    context.progress("collecting the results", None)
    identified = replace(identified, origin=data.store.origin_of(IDENTIFY))
    content = report_content(data, identified, validation, read_history(folder, context))
    content = with_requests(content, data, context)
    pictures = pictures_of_fit(data, identified, context, fit)
    statistics = [PictureOfFit(of, identified.key, CAPTIONS[of], make) for of, make in pictures.items()]
    content = replace(content, statistics=tuple(statistics))
    with written(file, REPORT, context.overwrite) as temporary:
        build_report(content, temporary, context.progress, is_short)
    return ReportResult(warnings=[], file=str(file), origin=identified.origin)
