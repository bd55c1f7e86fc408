"""What `trend` answers: the parameters of one robot over many campaigns, alarms, and what their cause can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stiffcal.documents import CommandResult, Number, OrAbsent, Origin
from stiffcal.identification.answers.before_after import EstimatedValue
from stiffcal.model.summary import Where

VarianceSource: TypeAlias = Literal["manifest", "campaigns", "unknown"]
Cause: TypeAlias = Literal["wear", "stiffened", "set-up", "undecided", "unexplained"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendCampaign:
    """One campaign."""

    folder: str
    """As it was named."""
    name: str
    """In its manifest."""
    date: str | None
    """ISO 8601, of its manifest's [trend]; null without one."""
    reduced_chi2: Number
    """Of its fit; null where the noise is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendParameter:
    """One parameter over all campaigns, of a compliance the stiffness."""

    name: str
    """``effect.place.symbol``."""
    effect: str
    """The effect's name."""
    where: Where
    """The effect's place."""
    unit: str
    """Of the values; of a compliance that of the stiffness."""
    values: list[EstimatedValue | None]
    """One a campaign, with the 95 % interval of its fit; null where its model does not hold the parameter."""
    variance_from: VarianceSource
    """Where the variance between campaigns is from; "unknown": there is no alarm."""
    relative: bool
    """Whether ``deviation`` is a share of the value."""
    deviation: Number
    """Standard deviation of one campaign's value on an unchanged robot, the fit's own uncertainty included; a share of
    the value where ``relative``, else in the unit of the fitted parameter. From the campaigns before the change."""
    sum_up: list[Number]
    """One a campaign: CUSUM of increases of the fitted parameter (of compliances: softer), in standard deviations; null
    where it is not charted."""
    sum_down: list[Number]
    """Likewise of decreases."""
    alarm: int | None
    """Number of the campaign that raises the alarm, from 0; null without one."""
    changed_from: int | None
    """Number of the first campaign after the change, from 0; null without an alarm."""
    change: Number
    """Share by which the mean of the campaigns since the change (without an alarm: the last campaign) differs from the
    mean of those before; null where that is not known."""
    change_interval: list[Number] | None
    """Both ends of its 95 % interval."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PossibleCause:
    """One explanation of a change of all parameters together."""

    kind: Literal["joint", "set-up"]
    """Joints that have changed, or something about the set-up."""
    effect: str
    """Of a set-up: the effect's name; "" of joints."""
    joints: list[int]
    """From 1; empty of a set-up."""
    p_value: float
    """Probability of so large or larger deviations from what it would show."""
    probability: float
    """Among all explanations that were compared, 0 to 1."""
    softer: bool | None
    """Of joints: whether they have become softer, or their play wider; null of a set-up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangeCause:
    """What has changed, judged by what each cause would show in all parameters together."""

    verdict: Cause
    """"wear": joints have become softer; "stiffened": a joint has become stiffer, as by a repair; "undecided": several
    explain it, or an effect that the model lacks does as well; "unexplained": none does."""
    since: int
    """Number of the first campaign after the change, from 0."""
    misfit_grew: bool
    """Whether the residuals over the noise are larger in every campaign since the change than before: the model lacks
    something since then, and no change of its joints alone is the cause."""
    causes: list[PossibleCause]
    """Most probable first; those below 1 % are left out. Where the residuals have grown, changes of the set-up that
    explain these as well come before all others."""
    explains_residuals: list[str]
    """Where the residuals have grown: effects of joints and links, with their places, that the model lacks and with
    which the residuals would be as before the change, best first; those that the data cannot distinguish from the best
    (odds below 20 to 1). Next to them no change of the set-up is named for certain."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendResult(CommandResult):
    """Answer of ``trend``."""

    schema: Literal["stiffcal/trend/1"] = "stiffcal/trend/1"
    campaigns: list[TrendCampaign]
    """In order of time."""
    parameters: list[TrendParameter]
    """All that any of the campaigns fits and that do not depend on its registration."""
    threshold: Number
    """A sum above this many standard deviations is an alarm; null where nothing is charted."""
    alarms: list[str]
    """Names of the parameters with an alarm."""
    cause: ChangeCause | None
    """Of the first change; null without an alarm, and where there are no load states to judge by."""
    max_change: OrAbsent[float] = None
    """The share that was allowed."""
    exceeded: list[str]
    """Names of the parameters whose change surely exceeds ``max_change``: all of the 95 % interval does."""
    figure: str | None
    """The picture's file; null without one."""
    origin: Origin
    """From whom the fits come: somebody else's where one of them is."""

    @property
    def passed(self) -> bool:
        """Whether there is no alarm and no change beyond the one allowed."""
        return not self.alarms and not self.exceeded
