"""Predict deflection and stiffness of a fitted robot under given loads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.compensation.load_table import LoadTable
from stiffcal.compensation.predicted_states import predicted_states, table_of_states, unknown_twists
from stiffcal.compensation.requested_loads import LoadPathRequest, OneLoad, described_path, requested_loads
from stiffcal.compensation.table_doubts import deflection_doubts
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import LOAD_PATHS, RunContext, open_store
from stiffcal.trust.output_kinds import PREDICTION
from stiffcal.trust.outputs import check_output

if TYPE_CHECKING:
    from stiffcal.compensation.predict_result import LoadPath, PredictResult
    from stiffcal.store.store_place import Documents, Stored


def predict_campaign(
    folder: Path,
    context: RunContext | None = None,
    poses: Path | LoadTable | OneLoad | None = None,
    load_path: LoadPathRequest | None = None,
    output: Path | None = None,
) -> PredictResult:
    """Predict deflection and Cartesian stiffness at the first measured frame.

    Parameters
    ----------
    folder : a campaign folder: one with a fit, or with logs to fit, or with a model file that values every parameter.
    context : store, progress and so on.
    poses : CSV with a column per joint (degrees) and Fx … Tz (N, N·m): base axes, on the robot, at the manifest's load
        point; one state a row. Or the same as arrays, or one load in words.
    load_path : instead of ``poses``.
    output : CSV, workbook or Parquet to write the result to.

    Returns
    -------
    PredictResult
        Every state, and the path of loads where one was asked for.

    Raises
    ------
    InputError : the input is wrong, or a load is more than the robot holds.
    """
    from stiffcal.compensation.link_parts import link_parts
    from stiffcal.compensation.predict_result import PredictResult
    from stiffcal.compensation.prediction import at_load_point, one_run, predict_states
    from stiffcal.model.balance.equilibrium import NoBalanceError

    context = context or RunContext()
    if (poses is None) == (load_path is None):
        code = FaultCode.OPTION_MISSING if poses is None else FaultCode.OPTION_CONFLICT
        reason = "nothing to predict is stated" if poses is None else "more than one thing to predict is given"
        mend = "give one of --pose A1,A2,… --force Fx,Fy,Fz, --poses FILE and --load-path F;F"
        place = "--pose" if isinstance(poses, OneLoad) else "--poses"
        raise InputError.at(code, "command line", place, reason, mend)
    if output is not None:
        check_output(output, PREDICTION, context.overwrite)
    campaign = load_campaign(Path(folder), check_files=False)
    loads, corners = requested_loads(campaign, poses, load_path)
    fitted = fitted_robot(campaign, context)
    context.progress("predicting", None)
    try:
        prediction = predict_states(
            fitted.robot, loads.joints, loads.wrench, fitted.setup, fitted.covariance, in_order=load_path is not None
        )
    except NoBalanceError as error:
        if isinstance(poses, OneLoad):
            raise error.of_load("command line", f"--force {poses.force}", "give a smaller force") from error
        if load_path is None:
            raise error.of_load(str(poses) if isinstance(poses, Path) else "poses", "", "give smaller loads") from error
        raise error.of_load("command line", f"--load-path {load_path.corners}", "give smaller loads") from error
    order = one_run(fitted.robot, len(loads.joints)) if load_path is not None else None
    angles, setup = fitted.robot.chain.model_angles(loads.joints), at_load_point(fitted.setup)
    parts = link_parts(fitted.robot, angles, loads.wrench, setup, order, fitted.link_compliances)
    path = None if load_path is None else described_path(campaign, load_path, loads, prediction, corners)
    result = PredictResult(
        warnings=[
            *loads.doubts,
            *deflection_doubts(prediction.deflection, loads.wrench, loads.where, loads.unit_mend),
            *fitted.warnings,
            *fitted.load_point_notes,
            *unknown_twists(fitted, parts),
        ],
        values_from=fitted.source,
        target=fitted.setup.target_names[0],
        states=predicted_states(loads, prediction, parts),
        load_path=path,
        file=None if output is None else str(output),
        joint_names=campaign.chain.joint_names,
        joint_units=campaign.chain.position_units,
    )
    if path is not None and context.trial is None:
        _keep(campaign, context, path)
    if output is not None:
        from stiffcal.store.table_files import write_table

        write_table(table_of_states(result), output, PREDICTION, overwrite=context.overwrite)
    return result


def _keep(campaign: Campaign, context: RunContext, path: LoadPath) -> None:
    """Keep the path in the store, where the report finds it; one of each name and pose."""

    def with_path(stored: Stored) -> Documents:
        kept = stored(LOAD_PATHS) or {"schema": "stiffcal/load-paths/1", "paths": []}
        kept_paths = [
            entry for entry in kept["paths"] if (entry.get("name"), entry.get("pose")) != (path.name, path.pose)
        ]
        return {LOAD_PATHS: kept | {"paths": [*kept_paths, document_of(path)]}}

    open_store(campaign.folder, context).commit(documents=with_path, command="predict")
