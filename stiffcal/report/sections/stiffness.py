"""The stiffness table with its uncertainty, and the other parameters of the model."""

from __future__ import annotations

from typing import Any

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Column, LeftOut, Paragraph, Section, Subheading, Table
from stiffcal.report.content import Document, ReportContent

ORDER = 30
_TITLE = "Stiffness"
# Above this share the half-width of the 95 % interval makes a value of little use by itself.
_POORLY_KNOWN = 0.5
_STIFFNESS_UNITS = {"rad/(N*m)": ("N·m/rad", 1.0), "m/N": ("N/µm", 1e-6), "rad/N": ("N/mrad", 1e-3)}
_PRINTED_UNITS = {"rad": ("mrad", 1e3), "m": ("mm", 1e3), "rad/(N*m)": ("µrad/(N·m)", 1e6), "m/N": ("µm/kN", 1e9)}


def section(content: ReportContent) -> Section | LeftOut:
    """Lay out every parameter with ± 95 %."""
    if content.identify is None:
        return LeftOut(_TITLE, "no model has been fitted yet: run “stiffcal identify”")
    parameters: list[Document] = list(content.identify.get("parameters", []))
    if not parameters:
        return LeftOut(_TITLE, "the model holds no parameter")
    blocks: list[Block] = [Paragraph(_lead(content.identify))]
    springs = [each for each in parameters if "stiffness" in each]
    others = [each for each in parameters if "stiffness" not in each]
    for unit, (printed, scale) in _STIFFNESS_UNITS.items():
        members = [each for each in springs if each.get("unit", "rad/(N*m)") == unit]
        if members:
            blocks.append(_stiffness_table(members, printed, scale, content.joint_names))
    if others:
        blocks.append(Subheading("Other parameters"))
        blocks.append(_other_table(others, content.joint_names))
    return Section(_TITLE, tuple(blocks), new_page=True)


def _lead(fit: Document) -> str:
    chi2, condition = fit.get("reduced_chi2"), fit.get("condition")
    text = "Values with half of their 95 % interval; the interval stands beside where it is not symmetric."
    if chi2 is not None:
        text += f" The residuals are {wording.digits(chi2**0.5)} times what the stated noise explains (root of reduced χ²)."
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


def _half_width(interval: list[float | None] | None, std: float | None) -> float | None:
    if interval and interval[0] is not None and interval[1] is not None:
        return (interval[1] - interval[0]) / 2.0
    return None if interval or std is None else 1.96 * std


def _interval_words(interval: list[float | None] | None, scale: float) -> str:
    if not interval:
        return wording.DASH
    low, high = ("" if end is None else wording.digits(end * scale) for end in interval)
    return f"{low} … {high}" if low and high else f"above {low}" if low else f"below {high}" if high else "unbounded"


def _verdict(parameter: Document, relative: float | None) -> str:
    if parameter.get("fixed"):
        return "given, not fitted"
    if not parameter.get("identifiable", True):
        return "not identifiable from these data"
    if relative is None:
        return "no upper bound" if parameter.get("stiffness_interval") else ""
    return "poorly known" if relative > _POORLY_KNOWN else ""


def _stiffness_table(members: list[Document], unit: str, scale: float, joint_names: tuple[str, ...]) -> Table:
    columns = (
        Column("place", align="left"), Column("effect", align="left"), Column("stiffness", unit),
        Column("± 95 %", unit), Column("± 95 %", "%"), Column("95 % interval", unit, align="left"),
        Column("remark", align="left", width=1.0),
    )  # fmt: skip
    rows = []
    poorly = []
    for each in members:
        value, interval = each.get("stiffness"), each.get("stiffness_interval")
        half = None if each.get("fixed") or value is None else _half_width(interval, each.get("stiffness_std"))
        relative = half / value if half is not None and value else None
        verdict = _verdict(each, relative)
        place = where_words(each.get("where", {}), joint_names)
        if verdict in ("poorly known", "no upper bound"):
            poorly.append(place)
        symbol = str(each["name"]).rsplit(".", 1)[-1]
        effect = str(each.get("effect", "")) + ("" if symbol == "c" else f" {symbol}")
        printed = [None if number is None else number * scale for number in (value, half)]
        rows.append(
            (place, effect, wording.digits(printed[0]), "± " + wording.digits(printed[1]) if half else wording.DASH,
             wording.DASH if relative is None else wording.digits(100 * relative, 2), _interval_words(interval, scale), verdict)
        )  # fmt: skip
    caption = f"Stiffness in {unit}, with 95 % uncertainty."
    if poorly:
        caption += f" Poorly known: {wording.listing(poorly)}; these loads hardly turned it."
    return Table(columns, tuple(rows), caption)


def _other_table(members: list[Document], joint_names: tuple[str, ...]) -> Table:
    columns = (
        Column("parameter", align="left"), Column("place", align="left", width=1.0), Column("value"),
        Column("± 95 %"), Column("unit", align="left"), Column("remark", align="left", width=1.0),
    )  # fmt: skip
    rows = []
    for each in members:
        unit = str(each.get("unit", ""))
        printed, scale = _PRINTED_UNITS.get(unit, (wording.unit_words(unit), 1.0))
        value = each.get("value")
        half = None if each.get("fixed") else _half_width(each.get("interval"), each.get("std"))
        relative = abs(half / value) if half is not None and value else None
        rows.append(
            (str(each["name"]), where_words(each.get("where", {}), joint_names),
             wording.digits(None if value is None else value * scale),
             "± " + wording.digits(half * scale) if half else wording.DASH, printed, _verdict(each, relative))
        )  # fmt: skip
    return Table(columns, tuple(rows), "Other parameters of the model, with 95 % uncertainty.")
