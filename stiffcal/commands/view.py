"""The page for a browser."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from stiffcal.documents import Origin
from stiffcal.results.command_results import ViewResult
from stiffcal.stages.steps import IDENTIFY, RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_results
from stiffcal.trust.output_kinds import PAGE
from stiffcal.trust.outputs import chosen_output, write_output

VIEW_FILE = "view.html"


def view_campaign(
    folder: Path, context: RunContext | None = None, output: Path | None = None, raw: bool = True
) -> ViewResult:
    """Write the page of a campaign: robot, residuals, ladder, effects in one HTML file.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    output : where to; default DIR/view.html.
    raw : whether the states' readings and the names of the logs are in it.

    Returns
    -------
    ViewResult
        The page. Nothing is fitted where the store is current, but for the profiles of parameters that bend their law
        or are near a bound.

    Raises
    ------
    InputError : the input is wrong, the file's name does not end in .html, or it cannot be written or holds
        something stiffcal did not write.
    """
    context = context or RunContext()
    file = chosen_output(output, Path(folder) / VIEW_FILE, PAGE, context.overwrite)
    page = page_of(folder, context, raw)
    write_output(file, page.html, PAGE, context.overwrite)
    return ViewResult(
        warnings=page.warnings,
        file=str(file),
        n_states=page.n_states,
        n_shown=page.n_shown,
        origin=cast(Origin, page.origin),
    )


@dataclass(frozen=True)
class PageOfCampaign:
    """The page, before it is written."""

    html: str
    """The file."""
    n_states: int
    """Load states of the campaign."""
    n_shown: int
    """Those that are drawn."""
    origin: str
    """From whom the results in it come."""
    warnings: list[str]
    """What it had to leave out, a line each."""


def page_of(folder: Path, context: RunContext, raw: bool = True) -> PageOfCampaign:
    """Return the page of a campaign; arguments and errors as of `view_campaign`."""
    data = up_to_date_states(folder, context)
    identified, validation = up_to_date_results(data, context)

    from stiffcal.report.gathering.plot_of_fit import statistics_page
    from stiffcal.view.gathering.content import view_content
    from stiffcal.view.page import build_page

    context.progress("collecting the results", None)
    content = view_content(data, identified, validation, raw)
    statistics = statistics_page(data, identified, context)
    content = replace(content, pages=[*content.pages, *([] if statistics is None else [statistics])])
    shown = 0 if content.states is None else len(content.states.run)
    fault = content.meshes_fault
    warnings = [f"the robot is drawn without the meshes of its URDF: {fault}"] if fault else []
    return PageOfCampaign(build_page(content), content.n_states, shown, data.store.origin_of(IDENTIFY), warnings)
