"""Another campaign's fitted model, judged on this campaign's data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from stiffcal.documents import Origin
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.model.assembled.measured_frames import FramePosition
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.stages.fit import fit_now
from stiffcal.stages.steps import (
    IDENTIFY,
    Ingested,
    RunContext,
    open_store,
    stored_fit,
)
from stiffcal.stages.threshold_verdict import check_thresholds

if TYPE_CHECKING:
    from stiffcal.campaign.manifest.thresholds import ThresholdsFile
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.model.assembled.composite import CompliantRobot


def validate_other_model(
    data: Ingested, folder: Path, context: RunContext, thresholds: ThresholdsFile | None
) -> ValidateResult:
    """Judge another campaign's fitted model on these data; nothing is stored."""
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.identification.answers.document import model_summary
    from stiffcal.ingest.sources import manifest_data_files
    from stiffcal.results.validate_answer import validate_result
    from stiffcal.store.index import FOREIGN
    from stiffcal.store.origin import worst_of
    from stiffcal.validation.heldout import residuals_of_model
    from stiffcal.validation.validate import validate_fit

    campaign = load_campaign(folder, check_files=False)
    store = open_store(folder, RunContext())
    stored, origin = stored_fit(store), store.origin_of(IDENTIFY)
    if stored is None:
        raise InputError.at(
            FaultCode.STORE_MISSING,
            str(folder),
            "store",
            "that campaign has no fitted model",
            f"run {command_line('identify', Path(folder))}",
        )
    if origin == FOREIGN and all((folder / file).exists() for file in manifest_data_files(campaign)):
        reason = "its store was not written by you"
        raise InputError.at(
            FaultCode.CONTENT_UNTRUSTED,
            str(folder),
            "store",
            reason,
            f"run {command_line('identify', Path(folder))}, to compute it again",
        )
    if campaign.chain.n_joints != data.campaign.chain.n_joints:
        reason = f"its robot has {campaign.chain.n_joints} joints, this one {data.campaign.chain.n_joints}"
        raise InputError.at(
            FaultCode.ROBOT_MISMATCH, str(folder), "robot", reason, "choose a campaign of the same robot"
        )
    robot = replace(placed_robot(campaign), chain=data.campaign.chain).with_values(stored.robot_values())
    if model_summary(robot) != stored.model:
        reason = "its model.toml has changed since the last fit"
        raise InputError.at(
            FaultCode.MODEL_MISMATCH, str(folder), "model.toml", reason, f"run {command_line('identify', Path(folder))}"
        )
    own = fit_now(data, "linear", context)
    if own is None:
        reason = "this campaign contains no load states to compare a model with"
        raise InputError.at(
            FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", reason, "choose a campaign with load runs"
        )
    fit = replace(own, robot=_with_own_frames(robot, data))
    validation = validate_fit(data.states, fit, residuals_of_model(data.states, fit))
    result = validate_result(data.states, validation)
    if origin == FOREIGN:
        data = replace(data, origin=origin)
    result = result.judged(check_thresholds(data, stored.parameters, result, context, thresholds))
    return replace(
        result,
        warnings=[*result.warnings, *_of_the_other_model(robot, stored, own, data)],
        model_of=str(folder),
        model=stored.model,
        origin=cast("Origin", worst_of([data.origin, origin])),
    )


def _of_the_other_model(robot: CompliantRobot, stored: IdentifyResult, own: Fit, data: Ingested) -> Iterator[str]:
    """Yield what another campaign's data could not give its model and these data show."""
    shown = {parameter.name for parameter in own.parameters if parameter.value is not None}
    of_geometry = {
        placed.parameter_name(spec.symbol)
        for placed in robot.placed
        if placed.changes_geometry or isinstance(placed.effect, FramePosition)
        for spec in placed.effect.parameters
    }
    unknown = [p.name for p in stored.parameters if p.value is None and p.name in shown - of_geometry]
    if unknown:
        yield (
            f"the other campaign's data do not identify {', '.join(unknown)}: taken as rigid, and what these joints "
            "give here is part of the error"
        )
    if data.states.absolute.any() and not any(placed.changes_geometry for placed in robot.placed):
        yield (
            "the other campaign's model does not hold the robot's geometry: the geometry errors of robot.toml are part "
            "of the error of the absolute poses"
        )


def _with_own_frames(robot: CompliantRobot, data: Ingested) -> CompliantRobot:
    """Return another campaign's robot with the frames of these absolute poses, found again with nothing else free.

    Tracker and targets stand elsewhere in every campaign; without absolute poses none is found with the robot.
    """
    from stiffcal.identification.fitting.identify import Settings, identify_parameters

    of_robot = tuple(placed for placed in robot.placed if not isinstance(placed.effect, FramePosition))
    frames = tuple(placed for placed in placed_robot(data.campaign).placed if isinstance(placed.effect, FramePosition))
    moved = replace(robot, placed=(*frames, *of_robot))
    if not frames:
        return moved
    fixed = frozenset(placed.parameter_name(spec.symbol) for placed in of_robot for spec in placed.effect.parameters)
    return identify_parameters(data.states, moved, Settings(fixed=fixed)).robot
