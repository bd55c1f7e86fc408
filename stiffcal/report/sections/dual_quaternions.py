"""Joint springs in paper 003's form: next to the matrix form, and its eq. 35 as printed apart."""

from __future__ import annotations

from stiffcal.report import wording
from stiffcal.report.blocks import Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.wording import significant

ORDER = 48
_TITLE = "The same springs in dual quaternions"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out both forms; nothing where the user has not asked for them (``identify --dual-quaternions``)."""
    comparison = None if content.identify is None else content.identify.dual_quaternions
    if comparison is None:
        return None
    text = (
        "Li et al. (2019) write poses as unit dual quaternions, eight numbers with no singular orientation, and "
        "identify joint compliances from their change (eq. 10 to 35), balanced on the deformed robot with its "
        "complementary stiffness (eq. 27 to 29). With the weights of the six displacements carried over by the exact "
        f"linear map this is the same estimate: the largest relative difference is "
        f"{significant(comparison.largest_relative_difference, 1)}. "
        "Eq. 35 as printed leaves the weights out and counts lengths and pure numbers alike: it changes with the unit "
        "of length."
    )
    columns = (
        TableColumn("parameter", align="left", mono=True), TableColumn("matrices", "N·m/rad"),
        TableColumn("dual quaternions", "N·m/rad"),
        TableColumn("eq. 35, metres", "N·m/rad"), TableColumn("eq. 35, millimetres", "N·m/rad"),
    )  # fmt: skip
    rows = tuple(
        (
            parameter.name,
            _stiffness(parameter.matrix),
            _stiffness(parameter.dual_quaternion),
            _stiffness(parameter.unweighted_in_metres),
            _stiffness(parameter.unweighted_in_millimetres),
        )
        for parameter in comparison.parameters
    )
    caption = "Stiffness of the joints that the fit identifies, each form carried on until its steps are rounding."
    return ReportSection(_TITLE, (Paragraph(text), TableBlock(columns, rows, caption)))


def _stiffness(compliance: float | None) -> str:
    return wording.significant(1.0 / compliance, 6) if compliance else wording.DASH
