"""The clamped robot: play, friction and torque-angle curve of every joint (004, Table 2 and Fig. 5 to 8)."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Column, Items, LeftOut, Paragraph, Picture, Section, Subheading, Table
from stiffcal.report.clamped_curves import ClampedCurve
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.clamped import draw_branches, draw_curves, draw_play_by_pose

ORDER = 44
_TITLE = "The clamped robot: play, friction and torque over angle"
_PER_PICTURE = 6
_DEGREE = 180.0 / math.pi


def section(content: ReportContent) -> Section | LeftOut | None:
    """Lay out definitions, tables and pictures; nothing where the campaign holds no clamped runs."""
    curves: tuple[ClampedCurve, ...] = tuple(content.extra.get("clamped", ()))
    if not curves or content.identify is None:
        return None
    told = content.identify["clamped"]
    known = [curve for curve in curves if curve.told is not None]
    blocks: list[Block] = [Paragraph(_definitions(told["definition"]))]
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
    return Section(_TITLE, tuple(blocks), new_page=True)


_PLAY_CAPTION = (
    "Play of each joint by pose, with its resolution (encoder step and noise) and the scatter between cycles. Crosses: "
    "poses left out, because the motion hardly exceeds the play. The line is the joint's play."
)


def _definitions(words: dict[str, Any]) -> str:
    return (
        f"Play: {words['play']}. Friction: {words['friction']}. Reversal error: {words['reversal_error']}. "
        f"{words['angle'][0].upper()}{words['angle'][1:]}. Left out are {words['left_out']}."
    )


def _entry(curve: ClampedCurve) -> dict[str, Any]:
    assert curve.told is not None
    return curve.told


def _degrees(radians: float | None, digits: int = 3) -> str:
    return wording.DASH if radians is None else wording.digits(radians * _DEGREE, digits)


def _play_table(curves: list[ClampedCurve]) -> Table:
    columns = (
        Column("joint", align="left"), Column("play", "°"), Column("± 95 %", "°"), Column("crossed within", "± N·m"),
        Column("between poses", "°"), Column("resolution", "°"), Column("friction", "N·m"),
        Column("reversal error", "°"), Column("torque from", align="left"),
    )  # fmt: skip
    rows = []
    for curve in curves:
        one = _entry(curve)
        friction = (
            f"{wording.digits(one['friction'])} ± {wording.digits(1.96 * one['friction_std'], 2)}"
            if one["friction_found"]
            else "none found"
        )
        rows.append(
            (
                curve.joint,
                _degrees(one["play"]) if one["play_found"] else "none found",
                _degrees(1.96 * one["play_std"], 2),
                wording.DASH if one["play_band"] is None else wording.digits(one["play_band"], 2),
                _degrees(one["spread_between_poses"], 2),
                _degrees(one["resolution"], 2),
                friction,
                _degrees(one["reversal_error"], 2),
                str(one["torque_from"]),
            )
        )
    return Table(columns, tuple(rows), "Play and friction of each joint, from all poses that are used.")


def _curve_table(curves: list[ClampedCurve]) -> Table:
    columns = (
        Column("joint", align="left"), Column("p1", "N·m/°"), Column("p2", "N·m/°²"), Column("p3", "N·m/°³"),
        Column("angle reached", "°"), Column("torque reached", "N·m"), Column("poses", align="left"),
    )  # fmt: skip
    rows = []
    for curve in curves:
        shape = _entry(curve)["curve"]
        cells = []
        for power, name in enumerate(("p1", "p2", "p3"), start=1):
            scale = 1.0 / _DEGREE**power
            half = 1.96 * math.sqrt(max(shape["covariance"][power - 1][power - 1], 0.0)) * scale
            cells.append(f"{wording.digits(shape[name] * scale)} ± {wording.digits(half, 2)}")
        reach = f"{_degrees(shape['reach'][0])} … {_degrees(shape['reach'][1])}"
        torque = f"{wording.digits(shape['torque'][0])} … {wording.digits(shape['torque'][1])}"
        rows.append((curve.joint, *cells, reach, torque, ", ".join(shape["runs"])))
    caption = (
        "Torque over angle, τ = p1 φ + p2 φ² + p3 φ³, φ in degrees from the flank: rising in all that was reached, and "
        "not to be used beyond. Uncertainties 95 %."
    )
    return Table(columns, tuple(rows), caption)


def _tangent_table(curves: list[ClampedCurve]) -> Table:
    columns = (
        Column("joint", align="left"), Column("torque", "N·m"), Column("angle", "°"), Column("stiffness", "N·m/rad"),
        Column("95 % interval", "N·m/rad"),
    )  # fmt: skip
    rows = []
    for curve in curves:
        for one in _entry(curve)["tangent_stiffness"]:
            low, high = one["interval"]
            rows.append(
                (
                    curve.joint,
                    wording.digits(one["torque"]),
                    _degrees(one["angle"]),
                    wording.digits(one["stiffness"]),
                    f"{wording.digits(low)} … {wording.digits(high)}",
                )
            )
    return Table(columns, tuple(rows), "Tangent stiffness over torque, play excluded.")


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
