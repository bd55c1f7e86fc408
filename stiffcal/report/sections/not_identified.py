"""What the data cannot identify: parameters and combinations that stay open."""

from __future__ import annotations

from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Items, LeftOut, Paragraph, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.sections.stiffness import where_words
from stiffcal.results.unidentified_words import unidentified_in_words

ORDER, IN_SHORT = 40, True
_TITLE = "What these data cannot identify"
# So many springs of one effect in the noise are named together.
_MANY = 4


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out what is not identifiable, and which combinations are known all the same."""
    if content.identify is None:
        return LeftOut(_TITLE, "no model has been fitted yet")
    elsewhere = content.parameters_on_pages
    groups = [
        group
        for group in content.identify.not_identifiable
        if not group.parameters or not set(group.parameters) <= elsewhere
    ]
    named = unidentified_in_words(groups)
    parameters = [parameter for parameter in content.identify.parameters if parameter.name not in elsewhere]
    open_ones = [
        f"{parameter.name} ({where_words(parameter.where, content.joint_names)}): no value"
        for parameter in parameters
        if not parameter.identifiable and not any(parameter.name in group.parameters for group in groups)
    ]
    hardly = _hardly([parameter for parameter in parameters if parameter.poorly_known], content.joint_names)
    if hardly and not named and not open_ones:
        text = "Identifiable but poorly determined:"
        return ReportSection(_TITLE, (Paragraph(text), Items(hardly)))
    if not named and not open_ones:
        return None
    blocks: list[Block] = [
        Paragraph("The following cannot be identified from these poses and loads. No number is given."),
        Items((*named, *open_ones, *hardly)),
    ]
    return ReportSection(_TITLE, tuple(blocks))


def _hardly(parameters: list[IdentifiedParameter], joint_names: tuple[str, ...]) -> tuple[str, ...]:
    """Name what is poorly known; springs of one effect that are all lost in the noise in one line."""
    in_noise: dict[str, list[str]] = {}
    for parameter in parameters:
        if parameter.above_noise is False:
            in_noise.setdefault(parameter.effect, []).append(parameter.name.partition(".")[2])
    together = {effect for effect, names in in_noise.items() if len(names) >= _MANY}
    lines = [
        f"{effect} {wording.listing(in_noise[effect], 24)}: not significant, less than three "
        "standard uncertainties from zero"
        for effect in sorted(together)
    ]
    lines += [
        f"{where_words(parameter.where, joint_names)}, {parameter.effect}: poorly determined{_range_words(parameter)}"
        for parameter in parameters
        if not (parameter.above_noise is False and parameter.effect in together)
    ]
    return tuple(lines)


def _range_words(parameter: IdentifiedParameter) -> str:
    """Return between which bounds a poorly determined stiffness lies; "" of other parameters."""
    ends = parameter.stiffness_interval
    if not ends or parameter.known_stiffness is None or wording.unit_words(parameter.unit) != "rad/(N·m)":
        return ""
    low, high = (wording.significant(end) for end in ends)
    above = f"and {high} N·m/rad" if ends[1] is not None else "N·m/rad and no upper bound"
    return f", 95 % between {low} {above}"
