"""The stiffness table with its uncertainty, and the other parameters of the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from stiffcal.identification.answers.before_after import BeforeAfter, EstimatedValue
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.model.summary import Where
from stiffcal.printed_units import printed_unit
from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, Paragraph, ReportSection, SubheadingBlock, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.report.estimates import STIFFNESS_UNITS, parameter_text, stiffness_text
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.value_words import on_limits, value_in_model

ORDER, IN_SHORT = 30, True
_TITLE = "Stiffness"
MOST_ON_FIRST_PAGE = 9


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out every parameter with ± 95 %."""
    if content.identify is None:
        return LeftOut(_TITLE, "no model has been fitted yet: run “stiffcal identify”")
    parameters = content.identify.parameters
    elsewhere = content.parameters_on_pages
    if parameters and len(elsewhere) == len(parameters):
        return LeftOut(_TITLE, "these runs measure friction only")
    parameters = [parameter for parameter in parameters if parameter.name not in elsewhere]
    if not parameters:
        return LeftOut(_TITLE, "the model contains no parameter")
    blocks: list[Block] = [Paragraph(_lead(content.identify))]
    springs = [parameter for parameter in parameters if _is_spring(parameter)]
    other_parameters = [parameter for parameter in parameters if not _is_spring(parameter)]
    for unit, (printed, scale) in STIFFNESS_UNITS.items():
        members = [spring for spring in springs if wording.unit_words(spring.unit) == unit]
        if members:
            blocks.append(_stiffness_table(members, printed, scale, content.joint_names, not_claimed(content)))
    if other_parameters:
        blocks.append(SubheadingBlock("Other parameters"))
        blocks.append(_other_table(other_parameters, content))
    return ReportSection(_TITLE, tuple(blocks))


def not_claimed(content: ReportContent) -> frozenset[int]:
    """Return the joints whose compliance absolute places give a value, but do not identify."""
    elasticity = None if content.validate is None else content.validate.elasticity
    joints = [] if elasticity is None else elasticity.joints
    return frozenset(joint.joint for joint in joints if joint.verdict != "identified")


def short_stiffness_table(
    parameters: Sequence[IdentifiedParameter],
    elsewhere: frozenset[str],
    joint_names: tuple[str, ...],
    unclaimed: frozenset[int] = frozenset(),
    changes: Sequence[BeforeAfter] = (),
) -> TableBlock | None:
    """Return the stiffness of each place in one column, for the first page; None where there is none.

    Parameters
    ----------
    parameters : of the fit. elsewhere : names of those that are shown on other pages.
    unclaimed : joints whose values are not identified, as `not_claimed` returns them.
    changes : what adding the missing effects does to the values: those that it shifts are grey, with the value after.
    """
    springs = [parameter for parameter in parameters if parameter.name not in elsewhere and _is_spring(parameter)]
    shown = springs[:MOST_ON_FIRST_PAGE]
    rows = tuple(_short_row(spring, joint_names, unclaimed) for spring in shown)
    if not rows:
        return None
    if changes:
        return _with_values_after(shown, rows, {change.name: change for change in changes}, len(springs) - len(shown))
    columns = (
        TableColumn("place", align="left"),
        TableColumn("effect", align="left"),
        TableColumn("stiffness"),
        TableColumn("unit", align="left"),
        TableColumn("remark", align="left", width=1.0),
    )
    more = len(springs) - len(rows)
    caption = "Stiffness, ± 95 %." + (f" {more} more under “{_TITLE}”." if more > 0 else "")
    return _without_empty_remarks(columns, list(rows), caption)


def _with_values_after(
    springs: Sequence[IdentifiedParameter],
    rows: Sequence[tuple[str, ...]],
    changes: Mapping[str, BeforeAfter],
    more: int,
) -> TableBlock:
    """Return the first page's table where an effect is missing: what that shifts has its value after, too."""
    columns = (
        TableColumn("place", align="left"),
        TableColumn("effect", align="left"),
        TableColumn("stiffness now"),
        TableColumn("with what is missing"),
        TableColumn("unit", align="left"),
        TableColumn("remark", align="left", width=1.0),
    )
    moved = {name: one for name, one in changes.items() if one.outside_interval and one.after is not None}
    made: list[tuple[str, ...]] = []
    for spring, (where, effect, text, unit, remark) in zip(springs, rows, strict=True):
        relative = moved[spring.name].relative if spring.name in moved else None
        sign = "+" if (relative or 0.0) > 0.0 else ""
        shifted = "" if relative is None else f"changes by {sign}{wording.share(relative)}"
        after = _value_after(spring, changes.get(spring.name))
        made.append((where, effect, text, after, unit, remark or shifted))
    caption = "Stiffness, ± 95 %. Grey: shifted by what the model lacks, not to be used; next to it the value with it."
    caption += f" {more} more under “{_TITLE}”." if more > 0 else ""
    doubtful = tuple((k, 2) for k, spring in enumerate(springs) if spring.name in moved)
    return replace(_without_empty_remarks(columns, made, caption), doubtful=doubtful)


def _value_after(spring: IdentifiedParameter, change: BeforeAfter | None) -> str:
    """Return a spring's value with what is missing; "" of what is not fitted, or where nothing is known of a change."""
    if change is None or (spring.fixed and change.after is not None):
        return ""
    if not change.outside_interval and _has_interval(change.before) and _is_known(change.after):
        return "stays within ±"
    return value_in_model(change.after, printed_unit(change.unit)[1])


def _is_known(value: EstimatedValue | None) -> bool:
    return value is not None and value.value is not None and not value.at_bound


def _has_interval(value: EstimatedValue | None) -> bool:
    return value is not None and _is_known(value) and value.interval is not None


def _short_row(spring: IdentifiedParameter, joint_names: tuple[str, ...], unclaimed: frozenset[int]) -> tuple[str, ...]:
    unit, scale = STIFFNESS_UNITS[wording.unit_words(spring.unit)]
    remark = _spring_verdict(spring, unclaimed)
    return _place(spring, joint_names), _effect(spring), stiffness_text(spring, scale), unit, remark


def _place(spring: IdentifiedParameter, joint_names: tuple[str, ...]) -> str:
    return where_words(spring.where, joint_names)


def _effect(spring: IdentifiedParameter) -> str:
    """Return the effect, with the component where it has several."""
    symbol = spring.name.rsplit(".", 1)[-1]
    return spring.effect + ("" if symbol == "c" else f" {symbol}")


def _is_spring(parameter: IdentifiedParameter) -> bool:
    return parameter.is_compliance and wording.unit_words(parameter.unit) in STIFFNESS_UNITS


def _lead(fit: IdentifyResult) -> str:
    chi2, condition = fit.reduced_chi2, fit.condition
    text = "±: 95 % interval; both limits are given if it is not symmetric."
    if chi2 is not None:
        text += f" The residuals are {wording.significant(chi2**0.5)} times the stated noise (root of reduced χ²)."
    if fit.std_scaled_by_reduced_chi2:
        text += " The uncertainties are scaled by the reduced χ² of the fit, because the noise is unknown."
    if condition is not None:
        text += f" Condition number of the fit: {wording.significant(condition)}."
    elif fit.not_identifiable:
        text += " The condition number is infinite, as some parameters cannot be identified."
    return text


def where_words(where: Where, joint_names: tuple[str, ...]) -> str:
    """Write a place, a single joint with its name.

    Examples
    --------
    >>> where_words(Where(joints=[2]), ("A1", "A2"))
    'joint 2 (A2)'
    """
    joints = where.joints or []
    if len(joints) == 1 and 1 <= joints[0] <= len(joint_names) and not where.links and not where.pairs:
        name = joint_names[joints[0] - 1]
        return f"joint {joints[0]} ({name})"
    return wording.place(where)


def _spring_verdict(spring: IdentifiedParameter, unclaimed: frozenset[int]) -> str:
    """Return the remark on a spring; a value that the places do not support is no claim."""
    own = _verdict(spring)
    joints = spring.where.joints or []
    return own or ("not identified by these poses" if unclaimed.intersection(joints) else "")


def _verdict(parameter: IdentifiedParameter) -> str:
    if _is_poorly_known(parameter):
        return "poorly determined" + (", no upper bound" if _is_open_ended(parameter) else "")
    if parameter.fixed:
        return "fixed, not fitted"
    if not parameter.identifiable or parameter.value is None:
        return "not identifiable"
    if parameter.at_bound:
        return "at the limit of its range"
    if parameter.rests_on:
        return on_limits(parameter.rests_on)
    if parameter.above_noise is False:
        return "not significant (below 3σ)"
    return ""


def _is_poorly_known(parameter: IdentifiedParameter) -> bool:
    """Return whether a value was found, above the noise and off its bounds, with a wide interval."""
    estimated = parameter.identifiable and parameter.value is not None and not parameter.fixed
    if not estimated or parameter.at_bound or parameter.above_noise is False:
        return False
    return parameter.poorly_known or _is_open_ended(parameter)


def _is_open_ended(parameter: IdentifiedParameter) -> bool:
    interval = parameter.stiffness_interval
    return interval is not None and interval[1] is None


def _stiffness_table(
    members: list[IdentifiedParameter],
    unit: str,
    scale: float,
    joint_names: tuple[str, ...],
    unclaimed: frozenset[int],
) -> TableBlock:
    # The column on geometry only where a share is known.
    shared = any(spring.from_geometry is not None for spring in members)
    columns = (
        TableColumn("place", align="left"),
        TableColumn("effect", align="left"),
        TableColumn("stiffness, ± 95 %", unit),
        TableColumn("standard\nuncertainty", "%"),
        *(TableColumn("share of\ngeometry", "%"),) * shared,
        TableColumn("remark", align="left", width=1.0),
    )
    rows: list[tuple[str, ...]] = []
    for spring in members:
        value, std = spring.known_stiffness, spring.known_stiffness_std
        rows.append(
            (_place(spring, joint_names), _effect(spring), stiffness_text(spring, scale),
             wording.significant(100 * std / value, 2) if std and value else wording.DASH,
             *(wording.DASH if spring.from_geometry is None else f"{100.0 * spring.from_geometry:.0f}",) * shared,
             _spring_verdict(spring, unclaimed))
        )  # fmt: skip
    poorly = list(dict.fromkeys(_place(spring, joint_names) for spring in members if _is_poorly_known(spring)))
    caption = f"Stiffness in {unit}."
    if shared:
        caption += " Share of geometry: part of the variance caused by the tolerances of lengths and angles."
    if poorly:
        caption += (
            f" Poorly determined: {wording.listing(poorly)}; the loads produce little torque on it in these poses."
        )
    return _without_empty_remarks(columns, rows, caption)


def _without_empty_remarks(columns: tuple[TableColumn, ...], rows: list[tuple[str, ...]], caption: str) -> TableBlock:
    """Leave the last column out where no row has a remark."""
    last = None if any(row[-1] for row in rows) else -1
    return TableBlock(columns[:last], tuple(row[:last] for row in rows), caption)


def _included(parameter: IdentifiedParameter) -> str:
    """Return which conventions of the frames a value of geometry holds: then it is not that of the robot alone."""
    frames = [name for name in parameter.includes or () if name.startswith("frame.")]
    return f"includes {wording.listing(frames)}" if frames else ""


def _other_table(members: list[IdentifiedParameter], content: ReportContent) -> TableBlock:
    columns = (
        TableColumn("parameter", align="left"), TableColumn("place", align="left"), TableColumn("value, ± 95 %"),
        TableColumn("unit", align="left"), TableColumn("remark", align="left", width=1.0),
    )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for parameter in members:
        printed, scale = printed_unit(parameter.unit, content.drift_follows)
        place = where_words(parameter.where, content.joint_names)
        remark = _verdict(parameter) or _included(parameter)
        rows.append((parameter.name, place, parameter_text(parameter, scale), printed, remark))
    caption = "Other parameters of the model."
    if any(unit in ("µm/h", "mrad/h", "µm/K", "mrad/K") for *_, unit, _ in rows):
        caption += f" The drift is counted over the {content.drift_follows}."
    return _without_empty_remarks(columns, rows, caption)
