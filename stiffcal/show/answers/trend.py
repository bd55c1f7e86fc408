"""What `trend` shows: each parameter's course over the campaigns, and what its change comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import Units, quantity_of
from stiffcal.results.value_words import value_and_remark
from stiffcal.show.builder import PageBuilder, number
from stiffcal.show.parameters import add_values, joined_remarks, names_and_units
from stiffcal.wording import change_words, share, significant

if TYPE_CHECKING:
    from stiffcal.presentation.values import Column, Page
    from stiffcal.validation.trend_result import ChangeCause, PossibleCause, TrendParameter, TrendResult

VERDICTS = {
    "wear": "wear: the changes are those of a joint that becomes softer, and no change of the set-up explains them",
    "stiffened": "a joint has become stiffer: no wear, but possibly a repair or replacement",
    "set-up": "a change of the set-up: it explains the changes of all parameters, and no joint alone does",
    "undecided": "undecided: several causes would explain these changes",
    "unexplained": "unexplained: neither a joint nor a change of the set-up explains these changes",
}


def page(result: TrendResult, details: bool) -> Page:
    """Return each parameter's first and last value, its change, and the chart's verdict."""
    made = PageBuilder("One robot over its campaigns")
    dates = [campaign.date or "" for campaign in result.campaigns]
    span = f", {dates[0]} to {dates[-1]}" if dates[0] else ""
    made.say(f"{len(result.campaigns)} campaigns{span}", "campaigns")
    _add_parameters(made, result, details)
    if result.figure is not None:
        made.say(f"parameters over the campaigns: {result.figure}", "written")
    if result.cause is not None:
        _add_cause(made, result, result.cause)
    elif result.threshold is not None and not result.alarms:
        made.say("no alarm: no parameter has changed by more than the scatter between campaigns", "no-alarm")
    for name in result.exceeded:
        made.say(f"more than {share(result.max_change)} change: {name}", "exceeded")
    return made.page()


def _add_parameters(made: PageBuilder, result: TrendResult, details: bool) -> None:
    units = Units((row.unit, [one.value for one in row.values if one is not None]) for row in result.parameters)
    unit_of = [units.of(quantity_of(row.unit)) for row in result.parameters]
    named = names_and_units(
        [
            (row.effect, row.where, row.name, row.unit, unit)
            for row, unit in zip(result.parameters, unit_of, strict=True)
        ]
    )
    rows = []
    for row, name, unit in zip(result.parameters, named.names, unit_of, strict=True):
        (first, of_first), (last, of_last) = (value_and_remark(row.values[k], unit) for k in (0, -1))
        remarks = joined_remarks((_remark(row, result), of_first, of_last))
        rows.append((name, first, last, *named.unit_of(unit), change_words(row.change), _deviation(row), remarks))
    values = (number(named.title("first"), named.several), number(named.title("last")))
    last_ones = (number("change"), number("varies by", True), "remark")
    titles: list[str | Column] = ["parameter", *values, *named.unit_title, *last_ones]
    add_values(made, titles, rows, details)


def _deviation(row: TrendParameter) -> str:
    if row.deviation is None:
        return "not known"
    return share(row.deviation) if row.relative else significant(row.deviation, 2)


def _remark(row: TrendParameter, result: TrendResult) -> str:
    if row.alarm is None or row.changed_from is None:
        return "" if row.variance_from != "unknown" else "not judged"
    return f"alarm in {_campaign(result, row.alarm)}, changed from {_campaign(result, row.changed_from)}"


def _campaign(result: TrendResult, number: int) -> str:
    campaign = result.campaigns[number]
    return campaign.date or campaign.folder


def _add_cause(made: PageBuilder, result: TrendResult, cause: ChangeCause) -> None:
    made.say(f"since {_campaign(result, cause.since)}: {VERDICTS[cause.verdict]}", f"cause-{cause.verdict}")
    if cause.misfit_grew:
        made.say("  the residuals have grown since then: the model lacks an effect (stiffcal diagnose)", "misfit-grew")
    if cause.explains_residuals:
        made.say(f"  any one of these would explain them: {', '.join(cause.explains_residuals)}", "explains-residuals")
    for one in cause.causes:
        made.say(
            f"  {_cause(one)}: probability {share(one.probability)} among the compared causes, "
            f"p = {significant(one.p_value, 2)}",
            "possible-cause",
        )


def _cause(one: PossibleCause) -> str:
    if one.kind == "set-up":
        return one.effect
    joints = ", ".join(str(joint) for joint in one.joints)
    return f"joint{'s' * (len(one.joints) > 1)} {joints} {'softer' if one.softer else 'stiffer'}"
