"""The numbers for other programs: states as CSV, workbook or Parquet, the model as JSON, the robot as URDF or rows."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.campaign.loading import load_campaign
from stiffcal.compensation.exports.row_options import RowOptions
from stiffcal.results.command_results import ExportResult
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.value_words import shifted_warning
from stiffcal.stages.diagnoses.current import shifted_by_missing
from stiffcal.stages.exported import model_document, readings_with_fit, states_with_residuals
from stiffcal.stages.fit import up_to_date_fit_at_hand
from stiffcal.stages.steps import Ingested, RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from stiffcal.store.table_files import write_table
from stiffcal.trust.output_kinds import EXPORT, TABLES
from stiffcal.trust.outputs import chosen_output, write_output

if TYPE_CHECKING:
    from stiffcal.compensation.exports.controller import ControllerOptions

CODE = (".c", ".st")


STATES_FILE = "states.csv"


def export_campaign(
    folder: Path,
    context: RunContext | None = None,
    output: Path | None = None,
    *,
    raw_text: bool = False,
    loop: ControllerOptions | None = None,
    rows: RowOptions | None = None,
) -> ExportResult:
    """Write a campaign's states or model to a file, whose ending decides which.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    output : default DIR/states.csv.
        ``*.csv``, ``*.xlsx`` or ``*.parquet``: load states with measured, predicted and residual; ``*.json``: the fit
        with its model; ``*.urdf``: the robot, with the stiffness of its joints in an element of its own; ``*.toml``:
        the calibrated robot as a robot file; ``*.xml``: the robot for MuJoCo, with its springs; ``*.c``: the
        compensation of a controller's loop as C99, with its header; ``*.st``: the same as Structured Text (IEC
        61131-3).
    raw_text : leave texts in a CSV file as they are, also those that a spreadsheet takes for formulas.
    loop : how the loop runs, for code; None: as `ControllerOptions` is.
    rows : of a robot file; None: in the convention of the campaign's own.

    Returns
    -------
    ExportResult
        The file, and what is in it.

    Raises
    ------
    InputError : the input is wrong, the file's ending is none of these, or it holds something stiffcal did not write.
    """
    context = context or RunContext()
    output = chosen_output(output, Path(folder) / STATES_FILE, EXPORT, context.overwrite)
    ending = output.suffix.lower()
    if ending in CODE or ending == ".xml":
        return _write_model(Path(folder), context, output, loop)
    data = up_to_date_states(folder, context)
    identified, fit = up_to_date_fit_at_hand(data, context)
    warnings: list[str] = []
    if ending in TABLES:
        up_to_date_validation(data, identified, context, fit)
        table = states_with_residuals(data) if len(data.states) else readings_with_fit(data)
        write_table(table, output, EXPORT, raw_text=raw_text, overwrite=context.overwrite)
        holds = f"{table.num_rows} readings with measured, predicted and residual"
        if len(data.states):
            holds = f"{table.num_rows} load states with measured, predicted and residual (held-out poses)"
    elif ending == ".json":
        text = json.dumps(model_document(data, identified), indent=2, ensure_ascii=False) + "\n"
        write_output(output, text, EXPORT, context.overwrite)
        holds = f"the model of fit {identified.fit_id} with uncertainty"
    else:
        holds, warnings = _write_robot(data, identified, output, rows or RowOptions(), context)
    if ending not in TABLES:
        warnings += shifted_warning(shifted_by_missing(data, identified) or ())
    return ExportResult(warnings=warnings, file=str(output), holds=holds)


def _write_model(folder: Path, context: RunContext, output: Path, loop: ControllerOptions | None) -> ExportResult:
    """Write the robot with its springs, as code or for MuJoCo."""
    from stiffcal.compensation.exports.controller import ControllerOptions, check_controller_code, write_controller_code
    from stiffcal.compensation.exports.mujoco import check_mujoco, write_mujoco
    from stiffcal.stages.diagnoses.model_verdict import model_verdict
    from stiffcal.stages.fitted_robot import fitted_robot

    is_code = output.suffix.lower() in CODE
    campaign = load_campaign(folder, check_files=False)
    if is_code:
        check_controller_code(campaign, output, overwrite=context.overwrite)
    else:
        check_mujoco(campaign)
    fitted = fitted_robot(campaign, context)
    verdict = model_verdict(folder, context, fitted)
    if is_code:
        loop = loop or ControllerOptions()
        code = write_controller_code(fitted, verdict, output, loop, overwrite=context.overwrite)
        return ExportResult(warnings=code.warnings, file=str(output), holds=code.holds)
    robot = write_mujoco(fitted, verdict, output, overwrite=context.overwrite)
    return ExportResult(warnings=robot.warnings, file=str(output), holds=robot.holds)


def _write_robot(
    data: Ingested, identified: IdentifyResult, output: Path, options: RowOptions, context: RunContext
) -> tuple[str, list[str]]:
    """Write the rigid robot, as URDF or as a robot file; return what is in it, and warnings."""
    setup = data.states.setup if len(data.states) else None
    if output.suffix.lower() == ".urdf":
        from stiffcal.compensation.exports.urdf import urdf_text
        from stiffcal.compensation.fitted_robot import known_from_below

        write_output(output, urdf_text(data.campaign, identified, setup), EXPORT, context.overwrite)
        holds = f"the robot as URDF with the geometry and the joint stiffness of fit {identified.fit_id}"
        return holds, list(known_from_below(identified))
    from stiffcal.compensation.exports.robot_file import robot_rows_text
    from stiffcal.results.geometry_words import CONVENTIONS

    rows = robot_rows_text(data.campaign, identified, setup, options.convention, strict=options.strict)
    write_output(output, rows.text, EXPORT, context.overwrite)
    beta = "without β" if options.strict else "with β where axes are nearly parallel"
    holds = f"the robot with the geometry of fit {identified.fit_id} as rows of {CONVENTIONS[rows.convention]}, {beta}"
    return holds, rows.warnings
