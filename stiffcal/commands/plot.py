"""One picture: load against deformation, or the residual against anything it might follow."""

from __future__ import annotations

from pathlib import Path

from stiffcal.report.gathering.one_picture import check_request, draw_picture
from stiffcal.results.command_results import PlotResult
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.trust.output_kinds import PLOT
from stiffcal.trust.outputs import chosen_output, written

PLOT_FILE = "plot.svg"


def plot_campaign(
    folder: Path,
    context: RunContext | None = None,
    output: Path | None = None,
    run: str | None = None,
    against: str | None = None,
    of: str | None = None,
) -> PlotResult:
    """Draw one picture of a campaign.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    output : ``*.svg``, ``*.png`` or ``*.pdf``; default DIR/plot.svg.
    run : only this run.
    against : draw the residual in held-out poses against this: ``torque:4``, ``angle:2`` (joint by number or name),
        ``approach:2`` (direction of the joint's last motion, absolute runs),
        ``force:x``, ``load``, ``time``, ``hold``, ``temperature``, ``state``; ``velocity`` or ``velocity:2``: friction
        over speed; None: load against deformation, or friction where there are no load states.
    of : a picture of the fit instead, of `stiffcal.report.gathering.plot_of_fit.OF_FIT`.

    Returns
    -------
    PlotResult
        The picture's file, and what is in it.

    Raises
    ------
    InputError : there is no such run, nothing to draw against, or the file cannot be written or holds something else.
    """
    context = context or RunContext()
    file = chosen_output(output, Path(folder) / PLOT_FILE, PLOT, context.overwrite)
    check_request(run, against, of)
    figure, drawn = draw_picture(up_to_date_states(folder, context), context, run, against, of)
    from stiffcal.report.figures.canvas import save_figure

    with written(file, PLOT, context.overwrite) as temporary:
        save_figure(figure, temporary)
    return PlotResult(warnings=[], file=str(file), drawn=drawn)
