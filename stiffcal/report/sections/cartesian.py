"""Cartesian stiffness in the poses that the campaign asks for: `[report]` in campaign.toml."""

from __future__ import annotations

from stiffcal.quantity import of_stiffness
from stiffcal.report import wording
from stiffcal.report.blocks import Paragraph, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import PoseStiffness, ReportContent
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import estimate

ORDER = 32
_TITLE = "Cartesian stiffness"
_AXES = ("along x", "along y", "along z", "about x", "about y", "about z")


def section(content: ReportContent) -> ReportSection | None:
    """Lay out a table for each pose."""
    if not content.stiffness_poses:
        return None
    text = (
        "Predicted by the fitted model at the loaded frame, base axes. Load alone: the load acts along the axis and "
        "all other directions are free, as a gauge along the load measures it. Others fixed: diagonal of the "
        "stiffness matrix, all other directions fixed."
    )
    tables = [_table(number, pose, content) for number, pose in enumerate(content.stiffness_poses, 1)]
    return ReportSection(_TITLE, (Paragraph(text), *tables))


def _table(number: int, pose: PoseStiffness, content: ReportContent) -> TableBlock:
    columns = (
        TableColumn("direction", align="left"), TableColumn("load alone, ± 95 %"), TableColumn("others fixed"),
        TableColumn("unit", align="left"),
    )  # fmt: skip
    rows = []
    for k, axis in enumerate(_AXES):
        unit = of_stiffness(k).usual
        held = wording.DASH if pose.held is None else wording.significant(float(pose.held[k]) * unit.factor)
        rows.append((axis, _stiffness(float(pose.compliance[k]), float(pose.std[k]), unit.factor), held, unit.name))
    angles = ", ".join(
        f"{name} {wording.position(float(at), k in content.prismatic_joints)}"
        for k, (name, at) in enumerate(zip(content.joint_names, pose.joints, strict=False), start=1)
    )
    return TableBlock(columns, tuple(rows), f"Stiffness at {pose.target}, pose {number}: {angles}.")


def _stiffness(compliance: float, std: float, scale: float) -> str:
    if compliance <= 0.0:
        return wording.DASH
    high, low = compliance + NORMAL_95 * std, compliance - NORMAL_95 * std
    interval = None if std == 0.0 else (1.0 / high, 1.0 / low if low > 0.0 else None)
    return estimate(1.0 / compliance, interval, scale)
