"""The clamped robot: play, friction and torque-angle curve of every joint (004, Table 2 and Fig. 5 to 8)."""

from __future__ import annotations

import math
from functools import partial

from stiffcal.experiments.clamped.results import Definition, JointResult
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Items,
    LeftOut,
    Paragraph,
    Picture,
    ReportSection,
    Subheading,
    TableBlock,
    TableColumn,
)
from stiffcal.report.clamped_curves import ClampedCurve
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.clamped import draw_branches, draw_curves, draw_play_by_pose
from stiffcal.uncertainty import NORMAL_95

ORDER = 44
_TITLE = "The clamped robot: play, friction and torque over angle"
_PER_PICTURE = 6
_DEGREE = 180.0 / math.pi


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out definitions, tables and pictures; nothing where the campaign holds no clamped runs."""
    curves: tuple[ClampedCurve, ...] = tuple(content.extra.get("clamped", ()))
    if not curves or content.identify is None:
        return None
    known = [curve for curve in curves if curve.result is not None]
    identified = content.identify.clamped
    assert identified is not None
    blocks: list[Block] = [Paragraph(_definitions(identified.definition))]
    if known:
        blocks += [_play_table(known), _curve_table(known)]
    remarks = [
        f"{curve.joint}, run {pose.run}: left out, {pose.left_out}"
        for curve in curves
        for pose in curve.poses
        if pose.left_out
    ]
    remarks += [f"run {pose.run}: {pose.remark}" for curve in curves for pose in curve.poses if pose.remark]
    if remarks:
        blocks += [Subheading("Left out, and limits"), Items(tuple(remarks))]
    for start in range(0, len(curves), _PER_PICTURE):
        part = curves[start : start + _PER_PICTURE]
        drawn = tuple(curve for curve in part if curve.shown.angle.size)
        if drawn:
            blocks.append(Picture(partial(draw_branches, drawn), _branches_caption(drawn)))
    if known:
        for start in range(0, len(known), _PER_PICTURE):
            some = tuple(known[start : start + _PER_PICTURE])
            blocks.append(Picture(partial(draw_curves, some), _curves_caption(some)))
    if any(len(curve.poses) > 1 for curve in curves):
        blocks.append(Picture(partial(draw_play_by_pose, curves), _PLAY_CAPTION))
    if known:
        blocks.append(_tangent_table(known))
    return ReportSection(_TITLE, tuple(blocks), new_page=True)


_PLAY_CAPTION = (
    "Play of each joint by pose, with its resolution (encoder step and noise) and the scatter between cycles. Crosses: "
    "poses left out, because the motion hardly exceeds the play. The line is the joint's play."
)


def _definitions(definition: Definition) -> str:
    return (
        f"Play: {definition.play}. Friction: {definition.friction}. Reversal error: {definition.reversal_error}. "
        f"{definition.angle[0].upper()}{definition.angle[1:]}. Left out are {definition.left_out}."
    )


def _result(curve: ClampedCurve) -> JointResult:
    assert curve.result is not None
    return curve.result


def _degrees(radians: float | None, digits: int = 3) -> str:
    return wording.DASH if radians is None else wording.digits(radians * _DEGREE, digits)


def _play_table(curves: list[ClampedCurve]) -> TableBlock:
    columns = (
        TableColumn("joint", align="left"),
        TableColumn("play", "°"),
        TableColumn("± 95 %", "°"),
        TableColumn("crossed within", "± N·m"),
        TableColumn("between poses", "°"),
        TableColumn("resolution", "°"),
        TableColumn("friction", "N·m"),
        TableColumn("reversal error", "°"),
        TableColumn("torque from", align="left"),
    )
    rows = []
    for curve in curves:
        joint = _result(curve)
        friction = (
            f"{wording.digits(joint.friction)} ± {wording.digits(NORMAL_95 * joint.friction_std, 2)}"
            if joint.friction is not None and joint.friction_std is not None
            else "none found"
        )
        rows.append(
            (
                curve.joint,
                _degrees(joint.play) if joint.play_found else "none found",
                _degrees(NORMAL_95 * joint.play_std, 2),
                wording.DASH if joint.play_band is None else wording.digits(joint.play_band, 2),
                _degrees(joint.spread_between_poses, 2),
                _degrees(joint.resolution, 2),
                friction,
                _degrees(joint.reversal_error, 2),
                str(joint.torque_from),
            )
        )
    return TableBlock(columns, tuple(rows), "Play and friction of each joint, from all poses that are used.")


def _curve_table(curves: list[ClampedCurve]) -> TableBlock:
    columns = (
        TableColumn("joint", align="left"),
        TableColumn("p1", "N·m/°"),
        TableColumn("p2", "N·m/°²"),
        TableColumn("p3", "N·m/°³"),
        TableColumn("angle reached", "°"),
        TableColumn("torque reached", "N·m"),
        TableColumn("poses", align="left"),
    )
    rows = []
    for curve in curves:
        shape = _result(curve).curve
        cells = []
        for power, coefficient in enumerate((shape.p1, shape.p2, shape.p3), start=1):
            scale = 1.0 / _DEGREE**power
            half = NORMAL_95 * math.sqrt(max(float(shape.covariance[power - 1, power - 1]), 0.0)) * scale
            cells.append(f"{wording.digits(coefficient * scale)} ± {wording.digits(half, 2)}")
        reach = f"{_degrees(shape.reach[0])} … {_degrees(shape.reach[1])}"
        torque = f"{wording.digits(shape.torque[0])} … {wording.digits(shape.torque[1])}"
        rows.append((curve.joint, *cells, reach, torque, ", ".join(shape.runs)))
    caption = (
        "Torque over angle, τ = p1 φ + p2 φ² + p3 φ³, φ in degrees from the flank: rising in all that was reached, and "
        "not to be used beyond. Uncertainties 95 %."
    )
    return TableBlock(columns, tuple(rows), caption)


def _tangent_table(curves: list[ClampedCurve]) -> TableBlock:
    columns = (
        TableColumn("joint", align="left"),
        TableColumn("torque", "N·m"),
        TableColumn("angle", "°"),
        TableColumn("stiffness", "N·m/rad"),
        TableColumn("95 % interval", "N·m/rad"),
    )
    rows = []
    for curve in curves:
        for tangent in _result(curve).tangent_stiffness:
            low, high = tangent.interval
            rows.append(
                (
                    curve.joint,
                    wording.digits(tangent.torque),
                    _degrees(tangent.angle),
                    wording.digits(tangent.stiffness),
                    f"{wording.digits(low)} … {wording.digits(high)}",
                )
            )
    return TableBlock(columns, tuple(rows), "Tangent stiffness over torque, play excluded.")


def _branches_caption(curves: tuple[ClampedCurve, ...]) -> str:
    names = wording.listing([curve.joint for curve in curves])
    return (
        f"Torque over angle of {names}, averaged over cycles, in the pose that moved the joint furthest: both "
        "directions, the fitted law, and the play in grey."
    )


def _curves_caption(curves: tuple[ClampedCurve, ...]) -> str:
    names = wording.listing([curve.joint for curve in curves])
    return (
        f"Torque over the spring's angle of {names}, counted from the flank, play, friction and the sensor's zero "
        "taken off: readings of all poses that are used, the third-order polynomial (dashed) and its 95 % interval."
    )
