"""One parameter over many campaigns: its values, its control chart, and how far it has changed."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from stiffcal.identification.answers.before_after import EstimatedParameter, estimated_parameters
from stiffcal.uncertainty import NORMAL_95
from stiffcal.validation.control_chart import FEWEST_CAMPAIGNS, ControlChart, control_chart
from stiffcal.validation.one_robot import amplitude_of
from stiffcal.validation.trend_result import (
    TrendParameter,
    VarianceSource,
)

if TYPE_CHECKING:
    from stiffcal.arrays import Floats
    from stiffcal.campaign.manifest.trend_settings import TrendSettings
    from stiffcal.identification.answers.fit_results import IdentifiedParameter


@dataclass(frozen=True)
class ChartedParameter:
    """A parameter that every campaign knows, ready for the chart."""

    name: str
    """``effect.place.symbol``."""
    values: Floats
    """(n,) one a campaign, of what is estimated: logarithms where ``relative``, else amplitudes."""
    std: Floats
    """(n,) the fits' standard uncertainties of these."""
    relative: bool
    """Whether the values are logarithms."""
    inverted: bool
    """Whether people read one over it: of compliances the stiffness."""
    between: float | None
    """Standard deviation between campaigns by the manifest, of these values; None where it does not say."""


def charted_parameter(
    name: str, found: Sequence[IdentifiedParameter], share: float | None, written: Sequence[TrendSettings]
) -> ChartedParameter:
    """Return a parameter as its chart has it.

    Parameters
    ----------
    found : what each campaign's fit found. share, written : the scatter between campaigns, of the manifests.
    """
    sizes, values = np.array([amplitude_of(p) for p in found]), np.array([p.value or 0.0 for p in found])
    std = np.array([p.std or 0.0 for p in found])
    stated = next((trend.parameters[name] for trend in written if name in trend.parameters), None)
    if not (sizes > 0.0).all():
        return ChartedParameter(name, sizes, std, relative=False, inverted=False, between=stated)
    inverted = found[0].is_compliance or not np.allclose(sizes, values)
    # a small relative change is as large in a value as in one over it
    between = share if stated is None else stated / float(np.mean(np.abs(values)))
    return ChartedParameter(name, np.log(sizes), std / np.abs(values), True, inverted, between)


def chart_of(charted: ChartedParameter, n_parameters: int) -> ControlChart | None:
    """Return the chart of a parameter; None where the variance between campaigns is not known."""
    if charted.between is not None:
        return control_chart(charted.values, n_parameters, np.hypot(charted.between, charted.std))
    if len(charted.values) < FEWEST_CAMPAIGNS:
        return None
    return control_chart(charted.values, n_parameters)


def trend_parameters(
    own: Sequence[Sequence[IdentifiedParameter]],
    charted: Sequence[ChartedParameter],
    charts: dict[str, ControlChart | None],
    shifted: Sequence[Collection[str]],
) -> list[TrendParameter]:
    """Return every parameter of the last campaigns, with its chart where it has one.

    Parameters
    ----------
    own, charted, charts : of the campaigns. shifted : of each, names of values that what its model lacks shifts.
    """
    shown = [{one.name: one for one in estimated_parameters(*campaign)} for campaign in zip(own, shifted, strict=True)]
    names = dict.fromkeys(name for campaign in reversed(shown) for name in campaign)
    by_name = {one.name: one for one in charted}
    return [
        _parameter(name, [campaign.get(name) for campaign in shown], by_name.get(name), charts.get(name))
        for name in names
    ]


def _parameter(
    name: str,
    estimates: Sequence[EstimatedParameter | None],
    charted: ChartedParameter | None,
    chart: ControlChart | None,
) -> TrendParameter:
    any_one = next(estimate for estimate in estimates if estimate is not None)
    alarm = None if chart is None else chart.first_alarm
    since = None if chart is None else chart.changed_from
    change = None if charted is None or chart is None else _change(charted, since)
    gaps: list[float | None] = [None] * len(estimates)
    source: VarianceSource = "unknown"
    if charted is not None and chart is not None:
        source = "campaigns" if charted.between is None else "manifest"
    return TrendParameter(
        name=name,
        effect=any_one.effect,
        where=any_one.where,
        unit=any_one.unit,
        values=[None if one is None else one.estimate for one in estimates],
        variance_from=source,
        relative=charted is not None and charted.relative,
        deviation=None if charted is None or chart is None else deviation_of(charted, since),
        sum_up=gaps if chart is None else cast("list[float | None]", chart.upper.tolist()),
        sum_down=gaps if chart is None else cast("list[float | None]", chart.lower.tolist()),
        alarm=alarm,
        changed_from=since,
        change=None if change is None else change[0],
        change_interval=None if change is None else [change[1], change[2]],
    )


def deviation_of(charted: ChartedParameter, since: int | None) -> float:
    """Return the standard deviation of one campaign's value on an unchanged robot.

    Parameters
    ----------
    charted : the parameter.
    since : number of the first campaign after a change; the values before and after it have means of their own.
    """
    if charted.between is not None:
        return float(np.sqrt(charted.between**2 + np.mean(charted.std**2)))
    parts = [part for part in np.split(charted.values, [] if since is None else [since]) if len(part)]
    squares = sum(float(np.sum((part - part.mean()) ** 2)) for part in parts)
    return math.sqrt(squares / max(len(charted.values) - len(parts), 1))


def _change(charted: ChartedParameter, since: int | None) -> tuple[float | None, float | None, float | None]:
    """Return the relative change of the value as people read it (of compliances the stiffness), with its 95 % ends.

    Student's quantile where the variance is estimated.
    """
    from scipy.special import stdtrit

    split = len(charted.values) - 1 if since is None else since
    before, after = charted.values[:split], charted.values[split:]
    if not len(before) or not charted.relative:
        return None, None, None
    spread = deviation_of(charted, split) * math.sqrt(1.0 / len(before) + 1.0 / len(after))
    dof = len(charted.values) - 2
    if charted.between is not None:
        quantile = NORMAL_95
    elif dof < 1:
        return None, None, None
    else:
        quantile = float(stdtrit(dof, 0.975))
    difference = float(after.mean() - before.mean()) * (-1.0 if charted.inverted else 1.0)
    ends = [math.expm1(difference + sign * quantile * spread) for sign in (-1.0, 1.0)]
    return math.expm1(difference), ends[0], ends[1]


def exceeds(parameter: TrendParameter, share: float) -> bool:
    """Return whether a parameter has surely changed by more than a share."""
    low, high = parameter.change_interval or (None, None)
    return (low is not None and low > share) or (high is not None and high < -share)
