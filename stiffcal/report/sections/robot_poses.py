"""The robot drawn in its poses, with residual arrows."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.figures import robot_poses as drawing

ORDER = 80
_TITLE = "The robot in its poses"
_MOST_POSES = 60


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out all poses over each other, then each by itself."""
    numbers = [number for number, run in enumerate(content.runs) if run.stick is not None]
    if not numbers:
        return LeftOut(_TITLE, "there are no load states, or the robot has no dimensions (a joint on a bench)")
    states = content.states if content.identify is not None else None
    scale = drawing.arrow_scale(content.runs, states) if states is not None else 1.0
    arrows = " No arrows: no model has been fitted."
    if states is not None:
        longest = max(
            float(np.linalg.norm(drawing.residual_arrows(states, n)[1], axis=1).max(initial=0.0)) for n in numbers
        )
        arrows = (
            " Arrows: residual (measured minus predicted) at the largest load of each direction, drawn "
            f"{wording.digits(scale)} times their length; the longest is {wording.length(longest)}."
        )
    overview = partial(drawing.draw_robot_poses, content.runs, states, scale)
    caption = f"All {wording.count(len(numbers), 'pose')} from three sides, base axes.{arrows}"
    blocks: list[Block] = [PictureBlock(overview, caption)]
    drawn_runs = (
        numbers
        if len(numbers) <= _MOST_POSES
        else [numbers[i] for i in np.linspace(0, len(numbers) - 1, _MOST_POSES).astype(int)]
    )
    columns = 4 if len(drawn_runs) <= 12 else 5
    for sheet in wording.in_sheets(drawn_runs, drawing.PER_SHEET, multiple=columns):
        names = f"{content.runs[sheet[0]].name} to {content.runs[sheet[-1]].name}"
        caption = f"Poses {names}, viewed from the side and from above; circles: joints, grey: the shadow on the floor."
        caption += " The bar in the last picture gives the scales." if states is not None else ""
        if len(drawn_runs) < len(numbers):
            caption += f" {len(drawn_runs)} of {len(numbers)} poses are drawn."
        blocks.append(
            PictureBlock(partial(drawing.draw_pose_sheet, content.runs, sheet, states, scale, columns), caption)
        )
    return ReportSection(_TITLE, tuple(blocks))
