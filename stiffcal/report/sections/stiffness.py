"""The stiffness table with its uncertainty, and the other parameters of the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from stiffcal.estimate import Estimate
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.model.summary import Where
from stiffcal.quantity import ShownUnit, Units
from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, Paragraph, ReportSection, SubheadingBlock, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.value_words import as_shown, remark, shifted_values, value_in_model, value_text

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
    shown = shown_estimates(content)
    springs = [parameter for parameter in parameters if _is_spring(parameter)]
    other_parameters = [parameter for parameter in parameters if not _is_spring(parameter)]
    units = units_of_springs(springs)
    for quantity in dict.fromkeys(spring.quantity for spring in springs):
        members = [spring for spring in springs if spring.quantity == quantity]
        unit = units.of(quantity.reciprocal())
        blocks.append(_stiffness_table(members, unit, content.joint_names, shown))
    if other_parameters:
        blocks.append(SubheadingBlock("Other parameters"))
        blocks.append(other_table(other_parameters, content.joint_names, shown))
    return ReportSection(_TITLE, tuple(blocks))


def shown_estimates(content: ReportContent) -> dict[str, Estimate]:
    """Return every parameter as tables show it, by name, with what diagnosis and validation say of it."""
    parameters = [] if content.identify is None else content.identify.parameters
    missing = content.diagnose is not None and content.diagnose.missing
    shifted = shifted_values(content.diagnose.before_after) if missing and content.diagnose is not None else ()
    return {parameter.name: as_shown(parameter, not_claimed(content), shifted) for parameter in parameters}


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
    units = units_of_springs(shown)
    rows = tuple(_short_row(spring, joint_names, unclaimed, units) for spring in shown)
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
    units = units_of_springs(springs)
    moved = {name: one for name, one in changes.items() if one.outside_interval and one.after is not None}
    made: list[tuple[str, ...]] = []
    for spring, (where, effect, text, unit, words) in zip(springs, rows, strict=True):
        relative = moved[spring.name].relative if spring.name in moved else None
        sign = "+" if (relative or 0.0) > 0.0 else ""
        shifted = "" if relative is None else f"changes by {sign}{wording.share(relative)}"
        after = _value_after(spring, changes.get(spring.name), units)
        made.append((where, effect, text, after, unit, words or shifted))
    caption = "Stiffness, ± 95 %. Grey: shifted by what the model lacks, not to be used; next to it the value with it."
    caption += f" {more} more under “{_TITLE}”." if more > 0 else ""
    doubtful = tuple((k, 2) for k, spring in enumerate(springs) if spring.name in moved)
    return replace(_without_empty_remarks(columns, made, caption), doubtful=doubtful)


def _value_after(spring: IdentifiedParameter, change: BeforeAfter | None, units: Units) -> str:
    """Return a spring's value with what is missing; "" of what is not fitted, or where nothing is known of a change."""
    if change is None or (spring.fixed and change.after is not None):
        return ""
    if (
        not change.outside_interval
        and _known_with_interval(change.before)
        and change.after is not None
        and change.after.is_known
    ):
        return "stays within ±"
    return value_in_model(change.after, units.of(change.quantity))


def _known_with_interval(value: Estimate | None) -> bool:
    return value is not None and value.is_known and value.interval is not None


def units_of_springs(springs: Sequence[IdentifiedParameter]) -> Units:
    """Return the units in which a table of springs shows their stiffness."""
    return Units((spring.quantity.reciprocal(), [spring.known_stiffness]) for spring in springs)


def _short_row(
    spring: IdentifiedParameter, joint_names: tuple[str, ...], unclaimed: frozenset[int], units: Units
) -> tuple[str, ...]:
    unit, estimate = units.of(spring.quantity.reciprocal()), as_shown(spring, unclaimed)
    return _place(spring, joint_names), _effect(spring), value_text(estimate, unit), unit.name, remark(estimate)


def _place(spring: IdentifiedParameter, joint_names: tuple[str, ...]) -> str:
    return where_words(spring.where, joint_names)


def _effect(spring: IdentifiedParameter) -> str:
    """Return the effect, with the component where it has several."""
    symbol = spring.name.rsplit(".", 1)[-1]
    return spring.effect + ("" if symbol == "c" else f" {symbol}")


def _is_spring(parameter: IdentifiedParameter) -> bool:
    return parameter.is_compliance and bool(parameter.quantity.inverse)


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


def _stiffness_table(
    members: list[IdentifiedParameter],
    unit: ShownUnit,
    joint_names: tuple[str, ...],
    shown: Mapping[str, Estimate],
) -> TableBlock:
    # The column on geometry only where a share is known.
    shared = any(spring.from_geometry is not None for spring in members)
    columns = (
        TableColumn("place", align="left"),
        TableColumn("effect", align="left"),
        TableColumn("stiffness, ± 95 %", unit.name),
        TableColumn("standard\nuncertainty", "%"),
        *(TableColumn("share of\ngeometry", "%"),) * shared,
        TableColumn("remark", align="left", width=1.0),
    )
    rows: list[tuple[str, ...]] = []
    for spring in members:
        estimate = shown[spring.name]
        relative = estimate.relative_std()
        rows.append(
            (_place(spring, joint_names), _effect(spring), value_text(estimate, unit),
             wording.DASH if relative is None else wording.significant(100.0 * relative, 2),
             *(wording.DASH if spring.from_geometry is None else f"{100.0 * spring.from_geometry:.0f}",) * shared,
             remark(estimate))
        )  # fmt: skip
    poorly = list(
        dict.fromkeys(_place(spring, joint_names) for spring in members if shown[spring.name].is_poorly_determined)
    )
    doubtful = tuple((k, 2) for k, spring in enumerate(members) if shown[spring.name].is_shifted)
    caption = f"Stiffness in {unit.name}."
    if shared:
        caption += " Share of geometry: part of the variance caused by the tolerances of lengths and angles."
    if poorly:
        caption += (
            f" Poorly determined: {wording.listing(poorly)}; the loads produce little torque on it in these poses."
        )
    if doubtful:
        caption += " Grey: shifted by what the model lacks, not to be used."
    return replace(_without_empty_remarks(columns, rows, caption), doubtful=doubtful)


def _without_empty_remarks(columns: tuple[TableColumn, ...], rows: list[tuple[str, ...]], caption: str) -> TableBlock:
    """Leave the last column out where no row has a remark."""
    last = None if any(row[-1] for row in rows) else -1
    return TableBlock(columns[:last], tuple(row[:last] for row in rows), caption)


def other_table(
    members: list[IdentifiedParameter], joint_names: tuple[str, ...], shown: Mapping[str, Estimate]
) -> TableBlock:
    """Return the table of parameters that are no springs.

    Parameters
    ----------
    members : in its rows. joint_names : of the robot. shown : every parameter as tables show it, by name.
    """
    columns = (
        TableColumn("parameter", align="left"), TableColumn("place", align="left"), TableColumn("value, ± 95 %"),
        TableColumn("unit", align="left"), TableColumn("remark", align="left", width=1.0),
    )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    units = Units((parameter.quantity, [parameter.value]) for parameter in members)
    for parameter in members:
        unit = units.of(parameter.quantity)
        place = where_words(parameter.where, joint_names)
        estimate = shown[parameter.name]
        rows.append((parameter.name, place, value_text(estimate, unit), unit.name, remark(estimate)))
    caption = "Other parameters of the model."
    counted = next((parameter.drift_follows for parameter in members if parameter.drift_follows is not None), None)
    if counted is not None:
        caption += f" The drift is counted over the {counted}."
    return _without_empty_remarks(columns, rows, caption)
