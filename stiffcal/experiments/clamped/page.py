"""The clamped robot as it is shown: play, friction and torque over angle of every joint (004, Table 2, Fig. 5 to 8)."""

from __future__ import annotations

import math

from stiffcal.errors import InputError
from stiffcal.experiments.clamped.curves import ClampedCurve, clamped_curves
from stiffcal.experiments.clamped.pictures import branches_picture, curves_picture, play_picture
from stiffcal.experiments.clamped.results import ClampedSection, Definition, JointResult
from stiffcal.experiments.measured import MeasuredRuns
from stiffcal.experiments.presentation import (
    Block,
    Column,
    Digits,
    Listing,
    Overview,
    Page,
    Plot,
    Sentence,
    Subheading,
    Table,
    Words,
)
from stiffcal.fault_codes import FaultCode
from stiffcal.uncertainty import NORMAL_95

_PER_PICTURE = 6
_DEGREE = 180.0 / math.pi
_TEXT = False


def clamped_overview(section: ClampedSection) -> Overview:
    """Return play, friction and reversal error joint by joint; the definition of play below."""
    columns = (
        Column("clamped", numbers=_TEXT),
        Column("play, ± 95 %", "°"),
        Column("friction", "N·m"),
        Column("reversal error", "°"),
        Column("torque reached", "N·m"),
        Column("poses", numbers=_TEXT),
    )
    rows: list[tuple[Words, ...]] = []
    for joint in section.joints:
        half = _degrees(NORMAL_95 * joint.play_std, 2)
        low, high = joint.curve.torque
        rows.append(
            (
                (f"joint {joint.joint} ({joint.name})",),
                (_degrees(joint.play), " ± ", half) if joint.play_found else ("none found, ± ", half),
                (Digits(joint.friction),) if joint.friction_found else ("none found",),
                (_degrees(joint.reversal_error, 2),),
                (Digits(low), " … ", Digits(high)),
                (", ".join(joint.runs),),
            )
        )
    if not rows:
        return Overview(())
    return Overview((Table(columns, tuple(rows)), Sentence((f"play: {section.definition.play}",), "definition")))


def clamped_page(data: MeasuredRuns, section: ClampedSection) -> Page | None:
    """Return definitions, tables and pictures; None where there is no curve."""
    curves = clamped_curves(data, section)
    if not curves:
        return None
    with_result = [(curve, curve.result) for curve in curves if curve.result is not None]
    blocks: list[Block] = [Sentence((_definitions(section.definition),), "definition")]
    if with_result:
        blocks += [_play_table(with_result), _curve_table(with_result)]
    remarks = [
        Sentence((f"{curve.joint}, run {pose.run}: left out, {pose.left_out}",), "run-left-out", "warning")
        for curve in curves
        for pose in curve.poses
        if pose.left_out
    ]
    remarks += [
        Sentence((f"run {pose.run}: {pose.remark}",), "torque-limited", "warning")
        for curve in curves
        for pose in curve.poses
        if pose.remark
    ]
    if remarks:
        blocks += [Subheading("Left out, and limits"), Listing(tuple(remarks))]
    for start in range(0, len(curves), _PER_PICTURE):
        drawn = tuple(curve for curve in curves[start : start + _PER_PICTURE] if curve.widest_pose.angle.size)
        if drawn:
            blocks.append(branches_picture(drawn))
    for start in range(0, len(with_result), _PER_PICTURE):
        blocks.append(curves_picture(tuple(curve for curve, _ in with_result[start : start + _PER_PICTURE])))
    if any(len(curve.poses) > 1 for curve in curves):
        blocks.append(play_picture(curves))
    if with_result:
        blocks.append(_tangent_table(with_result))
    title = "The clamped robot: play, friction and torque over angle"
    return Page(title, tuple(blocks), subject="clamped robot")


def clamped_plot(data: MeasuredRuns, section: ClampedSection | None, run: str | None) -> Plot:
    """Return torque over angle of every joint, or in one run.

    Raises
    ------
    InputError
        No whole sweep is left.
    """
    curves = () if section is None else clamped_curves(data, section)
    if run is not None:
        curves = tuple(curve.of_run(run) for curve in curves if any(pose.run == run for pose in curve.poses))
    drawn = tuple(curve for curve in curves if curve.widest_pose.angle.size)
    if not drawn:
        reason = "no whole sweep is left to draw" if run is None else f"no whole sweep is left of run {run}"
        raise InputError.at(
            FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", reason, "stiffcal identify says why"
        )
    names = ", ".join(f"{curve.joint} ({curve.widest_pose.run})" for curve in drawn)
    return Plot(branches_picture(drawn), f"torque over angle of {names}")


def _definitions(definition: Definition) -> str:
    return (
        f"Play: {definition.play}. Friction: {definition.friction}. Reversal error: {definition.reversal_error}. "
        f"{definition.angle[0].upper()}{definition.angle[1:]}. Left out are {definition.left_out}."
    )


def _degrees(radians: float | None, significant: int = 3) -> Digits:
    return Digits(None if radians is None else radians * _DEGREE, significant)


def _play_table(known: list[tuple[ClampedCurve, JointResult]]) -> Table:
    columns = (
        Column("joint", numbers=_TEXT),
        Column("play", "°"),
        Column("± 95 %", "°"),
        Column("crossed within", "± N·m"),
        Column("between poses", "°"),
        Column("resolution", "°"),
        Column("friction", "N·m"),
        Column("reversal error", "°"),
        Column("torque from", numbers=_TEXT),
    )
    rows: list[tuple[Words, ...]] = []
    for curve, joint in known:
        friction: Words = ("none found",)
        if joint.friction is not None and joint.friction_std is not None:
            friction = (Digits(joint.friction), " ± ", Digits(NORMAL_95 * joint.friction_std, 2))
        rows.append(
            (
                (curve.joint,),
                (_degrees(joint.play),) if joint.play_found else ("none found",),
                (_degrees(NORMAL_95 * joint.play_std, 2),),
                (Digits(joint.play_band, 2),),
                (_degrees(joint.spread_between_poses, 2),),
                (_degrees(joint.resolution, 2),),
                friction,
                (_degrees(joint.reversal_error, 2),),
                (str(joint.torque_from),),
            )
        )
    return Table(columns, tuple(rows), "Play and friction of each joint, from all poses that are used.")


def _curve_table(known: list[tuple[ClampedCurve, JointResult]]) -> Table:
    columns = (
        Column("joint", numbers=_TEXT),
        Column("p1", "N·m/°"),
        Column("p2", "N·m/°²"),
        Column("p3", "N·m/°³"),
        Column("angle reached", "°"),
        Column("torque reached", "N·m"),
        Column("poses", numbers=_TEXT),
    )
    rows: list[tuple[Words, ...]] = []
    for curve, joint in known:
        shape = joint.curve
        cells: list[Words] = []
        for power, coefficient in enumerate((shape.p1, shape.p2, shape.p3), start=1):
            scale = 1.0 / _DEGREE**power
            half = NORMAL_95 * math.sqrt(max(float(shape.covariance[power - 1, power - 1]), 0.0)) * scale
            cells.append((Digits(coefficient * scale), " ± ", Digits(half, 2)))
        reach: Words = (_degrees(shape.reach[0]), " … ", _degrees(shape.reach[1]))
        torque: Words = (Digits(shape.torque[0]), " … ", Digits(shape.torque[1]))
        rows.append(((curve.joint,), *cells, reach, torque, (", ".join(shape.runs),)))
    caption = (
        "Torque over angle, τ = p1 φ + p2 φ² + p3 φ³, φ in degrees from the flank: rising in all that was reached, and "
        "not to be used beyond. Uncertainties 95 %."
    )
    return Table(columns, tuple(rows), caption)


def _tangent_table(known: list[tuple[ClampedCurve, JointResult]]) -> Table:
    columns = (
        Column("joint", numbers=_TEXT),
        Column("torque", "N·m"),
        Column("angle", "°"),
        Column("stiffness", "N·m/rad"),
        Column("95 % interval", "N·m/rad"),
    )
    rows: list[tuple[Words, ...]] = []
    for curve, joint in known:
        for tangent in joint.tangent_stiffness:
            low, high = tangent.interval
            rows.append(
                (
                    (curve.joint,),
                    (Digits(tangent.torque),),
                    (_degrees(tangent.angle),),
                    (Digits(tangent.stiffness),),
                    (Digits(low), " … ", Digits(high)),
                )
            )
    return Table(columns, tuple(rows), "Tangent stiffness over torque, play excluded.")
