"""The stiffness table with its uncertainty, and the other parameters of the model."""

from __future__ import annotations

from typing import Any

from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, Paragraph, ReportSection, Subheading, TableBlock, TableColumn
from stiffcal.report.content import Document, ReportContent

ORDER = 30
_TITLE = "Stiffness"
# Above this share of the value the half-width of its 95 % interval leaves little; used where the document does not say.
_POORLY_KNOWN = 0.6
_STIFFNESS_UNITS = {"rad/(N·m)": ("N·m/rad", 1.0), "m/N": ("N/µm", 1e-6), "rad/N": ("N/mrad", 1e-3)}
_PRINTED_UNITS = {"rad": ("mrad", 1e3), "m": ("mm", 1e3), "rad/(N·m)": ("µrad/(N·m)", 1e6), "m/N": ("µm/kN", 1e9)}


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out every parameter with ± 95 %."""
    if content.identify is None:
        return LeftOut(_TITLE, "no model has been fitted yet: run “stiffcal identify”")
    parameters: list[Document] = list(content.identify.get("parameters", []))
    elsewhere = content.parameters_on_pages
    if parameters and len(elsewhere) == len(parameters):
        return LeftOut(_TITLE, "these runs tell friction alone")
    parameters = [each for each in parameters if each["name"] not in elsewhere]
    if not parameters:
        return LeftOut(_TITLE, "the model holds no parameter")
    blocks: list[Block] = [Paragraph(_lead(content.identify))]
    unit_of = {str(each["name"]): wording.unit_words(str(each.get("unit", ""))) for each in parameters}
    springs = [each for each in parameters if "stiffness" in each and unit_of[str(each["name"])] in _STIFFNESS_UNITS]
    others = [each for each in parameters if each not in springs]
    for unit, (printed, scale) in _STIFFNESS_UNITS.items():
        members = [each for each in springs if unit_of[str(each["name"])] == unit]
        if members:
            blocks.append(_stiffness_table(members, printed, scale, content.joint_names))
    if others:
        blocks.append(Subheading("Other parameters"))
        blocks.append(_other_table(others, content.joint_names))
    return ReportSection(_TITLE, tuple(blocks))


def _lead(fit: Document) -> str:
    chi2, condition = fit.get("reduced_chi2"), fit.get("condition")
    text = "Values with ± 95 %; the interval itself, which need not be symmetric, stands beside."
    if chi2 is not None:
        text += (
            f" The residuals are {wording.digits(chi2**0.5)} times what the stated noise explains (root of reduced χ²)."
        )
    if fit.get("std_scaled_by_reduced_chi2"):
        text += " The uncertainties are scaled by the reduced χ² of the fit, the noise not being known."
    if condition is not None:
        text += f" Condition number of the fit: {wording.digits(condition)}."
    return text


def where_words(where: dict[str, Any], joint_names: tuple[str, ...]) -> str:
    """Write a place, a single joint with its name.

    Examples
    --------
    >>> where_words({"joints": [2]}, ("A1", "A2"))
    'joint 2 (A2)'
    """
    joints = where.get("joints", [])
    if len(joints) == 1 and 1 <= joints[0] <= len(joint_names) and len(where) == 1:
        name = joint_names[joints[0] - 1]
        return f"joint {joints[0]} ({name})"
    return wording.place(where)


def _half_width(value: float | None, std: float | None, interval: list[float | None] | None) -> float | None:
    """Half of the 95 % interval where it is symmetric, else 1.96 standard uncertainties."""
    if value is None or std is None:
        return None
    if interval and interval[0] is not None and interval[1] is not None and not _lopsided(value, interval):
        return (interval[1] - interval[0]) / 2.0
    return 1.96 * std


def _lopsided(value: float, interval: list[float | None]) -> bool:
    low, high = interval
    return low is None or high is None or not 0.8 < (high - value) / max(value - low, 1e-300) < 1.25


def _interval_words(interval: list[float | None] | None) -> str:
    if not interval:
        return wording.DASH
    low, high = ("" if end is None else wording.digits(end) for end in interval)
    return f"{low} … {high}" if low and high else f"above {low}" if low else f"below {high}" if high else "unbounded"


def _verdict(parameter: Document) -> str:
    if _is_poorly_known(parameter):
        return "poorly known" + (", no upper bound" if _is_open_ended(parameter) else "")
    if parameter.get("fixed"):
        return "given, not fitted"
    if not parameter.get("identifiable", True) or parameter.get("value") is None:
        return "cannot be told from these data"
    if parameter.get("at_bound"):
        return "at the edge of what is possible"
    if parameter.get("above_noise") is False:
        return "within the noise"
    return ""


def _is_poorly_known(parameter: Document) -> bool:
    """Return whether a value was found, above the noise and off its bounds, with an interval that says little."""
    value, std = parameter.get("value"), parameter.get("std")
    found = parameter.get("identifiable", True) and value is not None and not parameter.get("fixed")
    if not found or parameter.get("at_bound") or parameter.get("above_noise") is False:
        return False
    poorly = parameter.get("poorly_known", bool(std and value and 1.96 * std > _POORLY_KNOWN * abs(value)))
    return bool(poorly) or _is_open_ended(parameter)


def _is_open_ended(parameter: Document) -> bool:
    interval: list[float | None] | None = parameter.get("stiffness_interval")
    return interval is not None and interval[1] is None


def _stiffness_table(members: list[Document], unit: str, scale: float, joint_names: tuple[str, ...]) -> TableBlock:
    columns = (
        TableColumn("place", align="left"),
        TableColumn("effect", align="left"),
        TableColumn("stiffness", unit),
        TableColumn("± 95 %", unit),
        TableColumn("standard uncertainty", "%"),
        TableColumn("95 % interval", unit, align="left"),
        TableColumn("remark", align="left", width=1.0),
    )
    rows: list[tuple[str, ...]] = []
    poorly: list[str] = []
    for each in members:
        value, std = (None if each.get(key) is None else each[key] * scale for key in ("stiffness", "stiffness_std"))
        ends = each.get("stiffness_interval")
        interval = [None if end is None else end * scale for end in ends] if ends else None
        half = None if each.get("fixed") else _half_width(value, std, interval)
        verdict = _verdict(each)
        place = where_words(each.get("where", {}), joint_names)
        if _is_poorly_known(each):
            poorly.append(place)
        symbol = str(each["name"]).rsplit(".", 1)[-1]
        effect = str(each.get("effect", "")) + ("" if symbol == "c" else f" {symbol}")
        rows.append(
            (place, effect, wording.digits(value),
             "± " + wording.digits(half) if half else wording.DASH,
             wording.digits(100 * std / value, 2) if std and value else wording.DASH, _interval_words(interval),
             verdict)
        )  # fmt: skip
    caption = f"Stiffness in {unit}, with 95 % uncertainty."
    if poorly:
        caption += f" Poorly known: {wording.listing(poorly)}; in these poses the loads hardly turn it."
    return _without_empty_remarks(columns, rows, caption)


def _without_empty_remarks(columns: tuple[TableColumn, ...], rows: list[tuple[str, ...]], caption: str) -> TableBlock:
    """Leave the last column out where no row has a remark."""
    last = None if any(row[-1] for row in rows) else -1
    return TableBlock(columns[:last], tuple(row[:last] for row in rows), caption)


def _other_table(members: list[Document], joint_names: tuple[str, ...]) -> TableBlock:
    columns = (
        TableColumn("parameter", align="left"), TableColumn("place", align="left", width=1.0), TableColumn("value"),
        TableColumn("± 95 %"), TableColumn("unit", align="left"), TableColumn("remark", align="left", width=1.0),
    )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for each in members:
        unit = str(each.get("unit", ""))
        printed, scale = _PRINTED_UNITS.get(wording.unit_words(unit), (wording.unit_words(unit), 1.0))
        value = each.get("value")
        half = None if each.get("fixed") else _half_width(value, each.get("std"), each.get("interval"))
        rows.append(
            (str(each["name"]), where_words(each.get("where", {}), joint_names),
             wording.digits(None if value is None else value * scale),
             "± " + wording.digits(half * scale) if half else wording.DASH, printed, _verdict(each))
        )  # fmt: skip
    return _without_empty_remarks(columns, rows, "Other parameters of the model, with 95 % uncertainty.")
