"""With and without compensation, where runs were measured with it (002, Fig. 6, 7; 003, Fig. 7–11)."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quantity import DELAY, LENGTH
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.compensation_content import ComparedPose, TimePair, WithAndWithout
from stiffcal.report.content import ReportContent
from stiffcal.report.figures import with_and_without as drawing
from stiffcal.wording import percent

ORDER = 55
_TITLE = "With and without compensation"
_MOST_CURVES = 3


def section(content: ReportContent) -> ReportSection | None:
    """Lay out the pairs of runs; nothing where no run was measured with compensation."""
    pairs = content.with_and_without
    if pairs is None or not (pairs.poses or pairs.over_time):
        return None
    blocks: list[Block] = []
    static = [pose for pose in pairs.poses if pose.off.name not in {pair.off.name for pair in pairs.over_time}]
    if static:
        blocks += [Paragraph(_answer(static), tone="key"), _table(static)]
        if len(static) > 1:
            blocks.append(
                PictureBlock(partial(drawing.draw_errors_by_pose, WithAndWithout(tuple(static))), _CAPTION_BARS)
            )
        worst_first = sorted(static, key=lambda pose: -pose.largest_off[0])
        blocks += [
            PictureBlock(partial(drawing.draw_before_and_after, pose), _caption(pose))
            for pose in worst_first[:_MOST_CURVES]
        ]
    for number, pair in enumerate(pairs.over_time):
        draw = drawing.draw_step if pair.kind == "step" else drawing.draw_process
        if number == 0 or pair.kind != pairs.over_time[number - 1].kind:
            blocks.append(SubheadingBlock("Step load" if pair.kind == "step" else "Process forces"))
        blocks.append(PictureBlock(partial(draw, pair), _caption_over_time(pair)))
    if pairs.over_time and pairs.played:
        blocks.append(Paragraph(pairs.played))
    return ReportSection(_TITLE, tuple(blocks))


_CAPTION_BARS = (
    "Error of the target under load in each pose, with and without compensation. Bars: rms over the loaded states; "
    "dashes: largest error."
)


def _answer(poses: list[ComparedPose]) -> str:
    before = float(np.sqrt(np.mean([pose.error_off[0] ** 2 for pose in poses])))
    after = float(np.sqrt(np.mean([pose.error_on[0] ** 2 for pose in poses])))
    text = (
        f"With compensation, the error under load decreases from {wording.length(before)} to "
        f"{wording.length(after)} (rms over {wording.count(len(poses), 'pose')} measured with and without): "
        f"{percent(1.0 - after / before)} of the deflection is compensated."
    )
    over = [pose for pose in poses if _reverses_motion(pose)]
    if over:
        names = wording.listing([pose.on.name for pose in over])
        text += f" In {names} the target moves against the load: overcompensation."
    return text


def _reverses_motion(pose: ComparedPose) -> bool:
    """Return whether the compensated target moves, on the whole, against where the load would move it."""
    work_off = float(np.sum(pose.off.force * pose.off.displacement))
    work_on = float(np.sum(pose.on.force * pose.on.displacement))
    return work_off > 0.0 and work_on < -0.05 * work_off


def _table(poses: list[ComparedPose]) -> TableBlock:
    unit = LENGTH.unit_for(pose.largest_off[0] for pose in poses)
    columns = (
        TableColumn("without", align="left", mono=True),
        TableColumn("with", align="left", mono=True),
        TableColumn("rms without", unit.name),
        TableColumn("rms with", unit.name),
        TableColumn("largest without", unit.name),
        TableColumn("largest with", unit.name),
        TableColumn("gone", "%"),
    )
    rows = tuple(
        (
            pose.off.name,
            pose.on.name,
            wording.significant(unit.factor * pose.error_off[0]),
            wording.significant(unit.factor * pose.error_on[0]),
            wording.significant(unit.factor * pose.largest_off[0]),
            wording.significant(unit.factor * pose.largest_on[0]),
            f"{100.0 * pose.gone:.0f}",
        )
        for pose in poses
    )
    return TableBlock(
        columns, rows, "Displacement of the target under load, in the same poses, without and with compensation."
    )


def _caption(pose: ComparedPose) -> str:
    return (
        f"{pose.off.name} and {pose.on.name}, {pose.pose}: measured deflection, including the motion of the "
        f"controller. The largest decreases from {wording.length(pose.largest_off[0])} to "
        f"{wording.length(pose.largest_on[0])}."
    )


def _caption_over_time(pair: TimePair) -> str:
    names = f"{pair.off.name} and {pair.on.name}"
    if pair.kind == "process":
        side_off, side_on = (_side_force(trace.wrench) for trace in (pair.off, pair.on))
        return (
            f"{names}: measured forces and moments, sensor axes. Perpendicular to the largest force: up to "
            f"{wording.significant(side_off)} N without and {wording.significant(side_on)} N with compensation."
        )
    if not np.isfinite(pair.delay):
        return f"{names}: the displacement of {wording.length(pair.uncorrected)} is never compensated by half."
    return (
        f"{names}: half of the deflection is compensated {wording.in_unit(pair.delay, DELAY.usual)} after "
        f"load application (grey), including filter and delay of the controller; {wording.length(pair.remaining)} of "
        f"{wording.length(pair.uncorrected)} remain. After unloading the correction persists for the same time, and "
        f"the target moves to the other side."
    )


def _side_force(wrench: Floats) -> float:
    """Return the force across the sensor's axis along which it is largest, N; all but the outermost readings."""
    force = wrench[:, :3] - np.median(wrench[:20, :3], axis=0)
    main = int(np.argmax(np.abs(force).max(axis=0)))
    return float(np.quantile(np.linalg.norm(np.delete(force, main, axis=1), axis=1), 0.98))
