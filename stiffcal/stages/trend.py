"""One robot over its fitted campaigns: charts of its parameters, and what the first change comes from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

from stiffcal.documents import Origin
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.stages.diagnoses.current import shifted_by_missing
from stiffcal.stages.fitted_campaign import FittedCampaign
from stiffcal.stages.steps import IDENTIFY, RunContext
from stiffcal.store.origin import worst_of
from stiffcal.validation.charted_parameter import (
    ChartedParameter,
    chart_of,
    charted_parameter,
    exceeds,
    trend_parameters,
)
from stiffcal.validation.control_chart import FEWEST_CAMPAIGNS, ControlChart
from stiffcal.validation.one_robot import parameters_of_robot
from stiffcal.validation.trend_result import ChangeCause, TrendCampaign, TrendParameter, TrendResult

if TYPE_CHECKING:
    from stiffcal.identification.answers.fit_results import IdentifiedParameter


def trend_of(
    campaigns: Sequence[FittedCampaign], context: RunContext, max_change: float | None, figure: str | None
) -> TrendResult:
    """Return the course of a robot's parameters.

    Parameters
    ----------
    campaigns : of one robot, oldest first. context : progress and so on.
    max_change : share by which a parameter may change. figure : where a picture of them will be.

    Raises
    ------
    InputError : the models share no parameter that all campaigns identify.
    """
    own = parameters_of_robot([campaign.fit.parameters for campaign in campaigns])
    charted = _charted(campaigns, own)
    charts = {chart.name: chart_of(chart, len(charted)) for chart in charted}
    shifted = [shifted_by_missing(campaign.data, campaign.fit) or () for campaign in campaigns]
    parameters = trend_parameters(own, charted, charts, shifted)
    return TrendResult(
        warnings=_warnings(campaigns, own, charts),
        campaigns=[_campaign(campaign) for campaign in campaigns],
        parameters=parameters,
        threshold=next((chart.threshold for chart in charts.values() if chart is not None), None),
        alarms=[parameter.name for parameter in parameters if parameter.alarm is not None],
        cause=_cause(campaigns, charted, parameters, context),
        max_change=max_change,
        exceeded=[p.name for p in parameters if max_change is not None and exceeds(p, max_change)],
        figure=figure,
        origin=cast(Origin, worst_of(campaign.data.store.origin_of(IDENTIFY) for campaign in campaigns)),
    )


def _charted(
    campaigns: Sequence[FittedCampaign], own: Sequence[Sequence[IdentifiedParameter]]
) -> list[ChartedParameter]:
    """Return the parameters that every campaign estimates.

    Raises
    ------
    InputError : there is none.
    """
    series: dict[str, list[IdentifiedParameter]] = {}
    for parameters in own:
        for parameter in parameters:
            if parameter.value is not None and parameter.std is not None and not parameter.at_bound:
                series.setdefault(parameter.name, []).append(parameter)
    whole = {name: found for name, found in series.items() if len(found) == len(campaigns)}
    if not whole:
        reason = "the models of these campaigns share no parameter that all of them identify"
        mend = "fit all campaigns with one model"
        raise InputError.at(FaultCode.MODEL_MISMATCH, str(campaigns[-1].folder), "model.toml", reason, mend)
    written = [campaign.data.campaign.manifest.trend for campaign in reversed(campaigns)]
    share = next((trend.between_campaigns for trend in written if trend.between_campaigns is not None), None)
    return [charted_parameter(name, found, share, written) for name, found in whole.items()]


def _cause(
    campaigns: Sequence[FittedCampaign],
    charted: Sequence[ChartedParameter],
    parameters: Sequence[TrendParameter],
    context: RunContext,
) -> ChangeCause | None:
    """Return what the first change can come from; None without an alarm, and without load states to judge by."""
    changed = [p for p in parameters if p.changed_from is not None]
    if not changed or not len(campaigns[-1].data.states):
        return None
    from stiffcal.stages.trend_causes import change_cause

    since = min(p.changed_from for p in changed if p.changed_from is not None)
    joints = {joint for p in changed for joint in p.where.joints or []}
    return change_cause(campaigns, charted, since, joints, context)


def _campaign(campaign: FittedCampaign) -> TrendCampaign:
    day = campaign.data.campaign.manifest.trend.date
    return TrendCampaign(
        folder=str(campaign.folder),
        name=campaign.data.campaign.name,
        date=None if day is None else day.isoformat(),
        reduced_chi2=campaign.fit.reduced_chi2,
    )


def _warnings(
    campaigns: Sequence[FittedCampaign],
    own: Sequence[Sequence[IdentifiedParameter]],
    charts: dict[str, ControlChart | None],
) -> list[str]:
    texts = []
    unknown = [name for name, chart in charts.items() if chart is None]
    if unknown:
        texts.append(
            f"no alarm is possible for {len(unknown)} of {len(charts)} parameters: {len(campaigns)} campaigns are "
            f"fewer than {FEWEST_CAMPAIGNS}, and no manifest states the scatter between campaigns ([trend]); "
            "stiffcal compare DIR1 DIR2 shows what has changed between two"
        )
    names = {parameter.name for parameters in own for parameter in parameters}
    if left := sorted(names - set(charts)):
        texts.append(f"not judged, because not all campaigns identify them: {', '.join(left)}")
    if any(len(kept) < len(campaign.fit.parameters) for kept, campaign in zip(own, campaigns, strict=True)):
        texts.append(
            "geometry and frames are not compared: they depend on the registration of the tracker in each campaign"
        )
    if any(campaign.fit.model != campaigns[0].fit.model for campaign in campaigns):
        texts.append("the models differ: a change may come from the model and not from the robot")
    robots = {campaign.data.campaign.chain.name for campaign in campaigns}
    if len(robots) > 1:
        texts.append(f"the robots have several names ({', '.join(sorted(robots))}): is it one and the same robot?")
    return texts
