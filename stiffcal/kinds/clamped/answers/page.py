"""The clamped robot as it is shown: low slope, friction and torque over angle of joints (004, Table 2, Fig. 5 to 8)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from stiffcal.errors import InputError
from stiffcal.estimate import Estimate
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.clamped.answers.curves import ClampedCurve, clamped_curves
from stiffcal.kinds.clamped.answers.results import ClampedSection, Definition, JointResult
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.presentation.values import Block, Column, Listing, Overview, Page, Plot, Sentence, Subheading, Table
from stiffcal.presentation.words import Digits, Joints, Names, Words
from stiffcal.quantity import ANGLE, Quantity
from stiffcal.uncertainty import NORMAL_95

_PER_PICTURE = 6
_TEXT = False


def clamped_overview(section: ClampedSection) -> Overview:
    """Return stiffness, low slope and friction by joint, and the reversal error by run; the definitions below.

    These are descriptions next to the parameters of the model, in the same units.
    """
    columns = _overview_columns(", ± 95 %")
    rows: list[tuple[Words, ...]] = []
    for joint in section.joints:
        rows.append(
            (
                (f"joint {joint.joint} ({joint.name})",),
                _estimate(joint, "chord", joint.chord_stiffness, joint.chord_interval),
                _low_slope(joint),
                _friction(joint),
            )
        )
    if not rows:
        return Overview(())
    sentences = [
        *map(_joint_sentence, section.joints),
        Sentence((f"chord stiffness: {CHORD}",), "definition"),
        Sentence((f"{LOW_SLOPE}: {section.definition.low_slope}",), "definition"),
        Sentence((f"reversal error: {section.definition.reversal_error}",), "definition"),
    ]
    return Overview((Table(columns, tuple(rows)),), (_runs_table(section), *sentences))


def _overview_columns(with_interval: str) -> tuple[Column, ...]:
    """Return the columns of the leading table; `with_interval` stands in the title of the first."""
    return (
        Column(f"clamped, without a model{with_interval}", numbers=_TEXT),
        Column("chord stiffness", "N·m/rad"),
        Column(LOW_SLOPE, "rad"),
        Column("friction", "N·m"),
    )


def clamped_main_table(section: ClampedSection) -> Table | None:
    """Return the leading table of the overview for the report, whose caption says ± 95 %; None without a joint."""
    table = next((block for block in clamped_overview(section).blocks if isinstance(block, Table)), None)
    return None if table is None else replace(table, columns=_overview_columns(""))


def _joint_sentence(joint: JointResult) -> Sentence:
    """Return over which torque a joint's stiffness is meant, how its tangent goes there, and the width of the law."""
    low, high = joint.curve.torque
    words: list[str | Digits | Estimate | Names | Joints] = [
        f"joint {joint.joint}: chord stiffness from ",
        Digits(low),
        " to ",
        Digits(high),
        " N·m",
    ]
    tangents = [tangent.stiffness for tangent in joint.tangent_stiffness]
    if tangents:
        words += [", with a tangent stiffness between ", Digits(min(tangents)), " and ", Digits(max(tangents))]
        words += [" N·m/rad", *([f" ({AT_SEARCH_LIMIT})"] if "chord" in joint.at_bound else [])]
    if joint.low_slope_found:
        words += [f"; the {LOW_SLOPE} is that of the law b·tanh(torque/w) with b = "]
        words += _estimate(joint, "width", joint.law_width, joint.law_width_interval, ANGLE)
    return Sentence(tuple(words), "joint")


# Not "play": that is a parameter of the model, whose value this description does not give.
LOW_SLOPE = "segment of low slope"
AT_SEARCH_LIMIT = "at the limit of the search"
CHORD = "chord of torque over angle over the measured range, segment of low slope excluded"


def _runs_table(section: ClampedSection) -> Table:
    """Return low slope and reversal error of each run, with the torque over which it went: friction grows with that."""
    columns = (
        Column("run", numbers=_TEXT),
        Column("joint", numbers=_TEXT),
        Column("torque measured", "N·m"),
        Column("reversal error", "rad"),
        Column(LOW_SLOPE, "rad"),
        Column("remark", numbers=_TEXT),
    )
    rows: list[tuple[Words, ...]] = [
        (
            (run.run,),
            (f"joint {run.joint}",),
            (Digits(run.torque_range[0]), " … ", Digits(run.torque_range[1])),
            (Digits(run.reversal_error),),
            (Digits(run.low_slope),) if run.low_slope else ("none found",),
            ("" if run.used else "excluded",),
        )
        for run in section.runs
    ]
    return Table(columns, tuple(rows))


_RUNS = "Segment of low slope and reversal error of each run, with its range of torque."


def clamped_page(data: MeasuredRuns, section: ClampedSection) -> Page | None:
    """Return definitions, tables and pictures; None where there is no curve."""
    curves = clamped_curves(data, section)
    if not curves:
        return None
    with_result = [(curve, curve.result) for curve in curves if curve.result is not None]
    blocks: list[Block] = [Sentence((_definitions(section.definition),), "definition")]
    if with_result:
        blocks += [
            _low_slope_table(with_result),
            replace(_runs_table(section), caption=_RUNS),
            _curve_table(with_result),
        ]
    remarks = [
        Sentence((f"{curve.joint}, run {pose.run}: excluded, {pose.left_out}",), "run-left-out", "warning")
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
        blocks += [Subheading("Excluded runs, and limits"), Listing(tuple(remarks))]
    from stiffcal.kinds.clamped.answers import pictures

    for start in range(0, len(curves), _PER_PICTURE):
        drawn = tuple(curve for curve in curves[start : start + _PER_PICTURE] if curve.widest_pose.angle.size)
        if drawn:
            blocks.append(pictures.branches_picture(drawn))
    for start in range(0, len(with_result), _PER_PICTURE):
        blocks.append(pictures.curves_picture(tuple(curve for curve, _ in with_result[start : start + _PER_PICTURE])))
    if any(len(curve.poses) > 1 for curve in curves):
        blocks.append(pictures.low_slope_picture(curves))
    for start in range(0, len(with_result), _PER_PICTURE):
        blocks.append(pictures.tangents_picture(tuple(curve for curve, _ in with_result[start : start + _PER_PICTURE])))
    title = "The clamped robot without a model: torque over angle"
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
        reason = "no complete sweep remains to draw" if run is None else f"no complete sweep remains of run {run}"
        raise InputError.at(
            FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", reason, "stiffcal identify gives the reason"
        )
    names = ", ".join(f"{curve.joint} ({curve.widest_pose.run})" for curve in drawn)
    from stiffcal.kinds.clamped.answers.pictures import branches_picture

    return Plot(branches_picture(drawn), f"torque over angle of {names}")


def _definitions(definition: Definition) -> str:
    return (
        f"Chord stiffness: {CHORD}. Segment of low slope: {definition.low_slope}. Friction: {definition.friction}. "
        f"Reversal error: {definition.reversal_error}. "
        f"{definition.angle[0].upper()}{definition.angle[1:]}. Excluded: {definition.left_out}."
    )


def _low_slope_table(known: list[tuple[ClampedCurve, JointResult]]) -> Table:
    columns = (
        Column("joint", numbers=_TEXT),
        Column(LOW_SLOPE, "rad"),
        Column("width b of the law", "rad"),
        Column("crossed within", "± N·m"),
        Column("between poses", "rad"),
        Column("resolution", "rad"),
        Column("friction", "N·m"),
        Column("torque from", numbers=_TEXT),
    )
    rows: list[tuple[Words, ...]] = []
    for curve, joint in known:
        rows.append(
            (
                (curve.joint,),
                _low_slope(joint),
                _law_width(joint),
                (Digits(joint.low_slope_band, 2),),
                (Digits(joint.spread_between_poses, 2),),
                (Digits(joint.resolution, 2),),
                _friction(joint),
                (str(joint.torque_from),),
            )
        )
    return Table(columns, tuple(rows), "Segment of low slope and friction of each joint, ± 95 %, from all used poses.")


def _low_slope(joint: JointResult) -> Words:
    if not joint.low_slope_found:
        return ("none found, at most ", Digits(joint.low_slope_interval[1], 2))
    return _estimate(joint, "low_slope", joint.low_slope, joint.low_slope_interval)


def _law_width(joint: JointResult) -> Words:
    if not joint.low_slope_found:
        return ("–",)
    return _estimate(joint, "width", joint.law_width, joint.law_width_interval)


def _friction(joint: JointResult) -> Words:
    if joint.friction is None:
        return ("none found",)
    half = NORMAL_95 * (joint.friction_std or 0.0)
    return _estimate(joint, "friction", joint.friction, [joint.friction - half, joint.friction + half])


def _estimate(
    joint: JointResult, symbol: str, value: float, interval: Sequence[float | None], quantity: Quantity | None = None
) -> Words:
    """Return a number with its 95 % interval; of one on which a search ended at a limit that is said, and no interval.

    Parameters
    ----------
    symbol : as in `JointResult.at_bound`. interval : both ends.
    quantity : in a sentence, what the number is of; None in a column that has a unit.
    """
    if symbol in joint.at_bound:
        known = Digits(value) if quantity is None else Estimate(value=value, interval=None, quantity=quantity)
        return (known, f", {AT_SEARCH_LIMIT}")
    return (Estimate(value=value, interval=list(interval), quantity=quantity),)


def _curve_table(known: list[tuple[ClampedCurve, JointResult]]) -> Table:
    columns = (
        Column("joint", numbers=_TEXT),
        Column("p1", "N·m/rad"),
        Column("p2", "N·m/rad²"),
        Column("p3", "N·m/rad³"),
        Column("angle reached", "rad"),
        Column("torque reached", "N·m"),
    )
    rows: list[tuple[Words, ...]] = []
    for curve, joint in known:
        shape = joint.curve
        cells: list[Words] = []
        for power, coefficient in enumerate((shape.p1, shape.p2, shape.p3), start=1):
            std = math.sqrt(max(float(shape.covariance[power - 1, power - 1]), 0.0))
            ends = [coefficient - NORMAL_95 * std, coefficient + NORMAL_95 * std]
            cells.append(_estimate(joint, f"p{power}", coefficient, ends))
        reach: Words = (Digits(shape.reach[0]), " … ", Digits(shape.reach[1]))
        torque: Words = (Digits(shape.torque[0]), " … ", Digits(shape.torque[1]))
        rows.append(((curve.joint,), *cells, reach, torque))
    caption = (
        "Torque over angle, τ = p1 φ + p2 φ² + p3 φ³, φ from the flank: monotonic over the measured range, not valid "
        "beyond it. p1 is the tangent stiffness at the flank. Uncertainties: 95 %."
    )
    return Table(columns, tuple(rows), caption)
