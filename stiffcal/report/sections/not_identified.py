"""What the data cannot tell: parameters and combinations that stay open."""

from __future__ import annotations

from typing import Any

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Items, LeftOut, Paragraph, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.sections.stiffness import where_words

ORDER = 40
_TITLE = "What these data cannot tell"
# So many springs of one effect in the noise are named together.
_MANY = 4


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out what is not identifiable, and which combinations are known all the same."""
    if content.identify is None:
        return LeftOut(_TITLE, "no model has been fitted yet")
    elsewhere = content.parameters_on_pages
    named = [
        _words(entry)
        for entry in content.identify.get("not_identifiable", [])
        if isinstance(entry, str) or not entry.get("parameters") or not set(entry["parameters"]) <= elsewhere
    ]
    open_ones = [
        f"{each['name']} ({where_words(each.get('where', {}), content.joint_names)}): no value"
        for each in content.identify.get("parameters", [])
        if not each.get("identifiable", True) and each["name"] not in elsewhere
    ]
    hardly = _hardly(
        [
            each
            for each in content.identify.get("parameters", [])
            if each.get("poorly_known") and each["name"] not in elsewhere
        ],
        content.joint_names,
    )
    if hardly and not named and not open_ones:
        text = "No parameter is beyond telling, but in these poses the loads tell little of the following."
        return ReportSection(_TITLE, (Paragraph(text), Items(hardly)))
    if not named and not open_ones and content.states is None:
        return None
    if not named and not open_ones:
        return ReportSection(
            _TITLE, (Paragraph("Every parameter of the model can be told from these poses and loads."),)
        )
    blocks: list[Block] = [
        Paragraph(
            "The following cannot be told from these poses and loads. No number is given for it, rather than a "
            "wrong one."
        ),
        Items((*named, *open_ones, *hardly)),
    ]
    return ReportSection(_TITLE, tuple(blocks))


def _hardly(parameters: list[dict[str, Any]], joint_names: tuple[str, ...]) -> tuple[str, ...]:
    """Name what is poorly known; springs of one effect that are all lost in the noise in one line."""
    in_noise: dict[str, list[str]] = {}
    for each in parameters:
        if each.get("above_noise") is False:
            in_noise.setdefault(str(each.get("effect")), []).append(str(each["name"]).partition(".")[2])
    together = {effect for effect, names in in_noise.items() if len(names) >= _MANY}
    lines = [
        f"{effect} {wording.listing(in_noise[effect], 24)}: within the noise, told from none at all by less than three "
        "standard uncertainties"
        for effect in sorted(together)
    ]
    lines += [
        f"{where_words(each.get('where', {}), joint_names)}, {each.get('effect', each['name'])}: hardly known, "
        f"{_range_words(each)}"
        for each in parameters
        if not (each.get("above_noise") is False and str(each.get("effect")) in together)
    ]
    return tuple(lines)


def _range_words(parameter: dict[str, Any]) -> str:
    """Say between which bounds a poorly known parameter lies, as a stiffness where it is one."""
    ends = parameter.get("stiffness_interval")
    if not ends or parameter.get("stiffness") is None or wording.unit_words(str(parameter.get("unit"))) != "rad/(N·m)":
        return "its 95 % interval is wider than the value itself"
    low, high = (wording.digits(end) for end in ends)
    above = f"and {high} N·m/rad" if ends[1] is not None else "N·m/rad and no upper bound"
    return f"95 % between {low} {above}"


def _words(entry: Any) -> str:
    """Write one entry of ``not_identifiable``: a sentence, or an object whose parts are joined."""
    if isinstance(entry, str):
        return entry
    for key in ("text", "why", "reason", "message"):
        if key in entry:
            return str(entry[key])
    parts = (f"{key.replace('_', ' ')}: {_joined(value)}" for key, value in entry.items())
    return "; ".join(parts)


def _joined(value: Any) -> str:
    return ", ".join(str(each) for each in value) if isinstance(value, list) else str(value)
