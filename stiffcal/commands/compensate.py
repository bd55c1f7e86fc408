"""Corrected joint targets for a path with known or logged forces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.campaign.loading import load_campaign
from stiffcal.compensation.corrected_path import CompensateRequest, corrected_path, judgement, path_error, table_of_path
from stiffcal.compensation.path import read_path
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from stiffcal.trust.output_kinds import CORRECTION, PATH_PICTURE
from stiffcal.trust.outputs import check_output, written

if TYPE_CHECKING:
    from stiffcal.compensation.compensate_result import CompensateResult


def compensate_campaign(
    folder: Path,
    options: CompensateRequest,
    context: RunContext | None = None,
    output: Path | None = None,
    picture: Path | None = None,
) -> CompensateResult:
    """Correct the joint targets of a path so that the loaded robot goes where it is wanted.

    Parameters
    ----------
    folder : a campaign folder with a fit, with logs to fit, or with a model file that values every parameter.
    options : path, forces, and what is to be reached.
    context : store, progress and so on.
    output : CSV, workbook or Parquet for the corrected joints with the predicted deflection and what the model's
        uncertainty leaves of it.
    picture : SVG, PNG or PDF of the error along the path, with and without the correction.

    Returns
    -------
    CompensateResult
        Every pose of the path, corrected.

    Raises
    ------
    InputError : the input is wrong, a load is more than the robot holds, or a pose cannot be had.
    """
    context = context or RunContext()
    for file, kind in ((output, CORRECTION), (picture, PATH_PICTURE)):
        if file is not None:
            check_output(file, kind, context.overwrite)
    campaign = load_campaign(Path(folder), check_files=False)
    fitted = fitted_robot(campaign, context)
    setup, target = fitted.aimed_at(options.target)
    path = read_path(fitted, setup, options.path, options.forces, options.start)
    if picture is not None and len(path.table) < 2:
        mend = "give a path of two poses or more, or leave --picture out"
        raise InputError.at(FaultCode.PATH_INVALID, str(options.path), "", "a path with one pose cannot be drawn", mend)
    context.progress("correcting", None)
    result = corrected_path(fitted, path, target, options)
    if options.judge is not None:
        other = RunContext(progress=context.progress, notify=context.notify)
        judge = fitted_robot(load_campaign(options.judge, check_files=False), other)
        result = replace(result, judged=judgement(fitted, judge, options, path, result.found))
    result = replace(
        result,
        file=None if output is None else str(output),
        picture=None if picture is None else str(picture),
    )
    if output is not None:
        from stiffcal.store.table_files import write_table

        write_table(table_of_path(campaign.chain, result, path), output, CORRECTION, overwrite=context.overwrite)
    if picture is not None:
        from stiffcal.report.figures.canvas import save_figure
        from stiffcal.report.figures.path_error import draw_path_error

        with written(picture, PATH_PICTURE, context.overwrite) as temporary:
            save_figure(draw_path_error(path_error(fitted, path, result, options.normal)), temporary)
    return result
