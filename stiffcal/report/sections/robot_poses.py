"""The robot drawn in its poses, with residual arrows."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.report import wording
from stiffcal.report.blocks import LeftOut, PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.figures import robot_poses as drawing

ORDER = 80
_TITLE = "Robot poses"
_MOST_POSES = 12
_COLUMNS = 6


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out a few poses, each by itself: those with the largest residuals, and others evenly spread."""
    numbers = _distinct(content)
    if not numbers:
        return LeftOut(
            _TITLE, "there are no load states, or the robot has no dimensions (single joint on a test bench)"
        )
    has_residuals = content.identify is not None and content.states is not None and bool(content.states.used.any())
    states = content.states if has_residuals else None
    scale = drawing.arrow_scale(content.runs, states) if states is not None else 1.0
    longest = [0.0] * len(content.runs)
    if states is not None:
        for number in numbers:
            arrows = drawing.residual_arrows(states, number)[1]
            longest[number] = float(np.linalg.norm(arrows, axis=1).max(initial=0.0))
    chosen = _chosen(numbers, longest)
    caption = _caption(len(chosen), len(numbers), has_residuals)
    if states is not None:
        caption += (
            " Arrows: residual (measured minus predicted) at the largest load of each direction, "
            f"enlarged {wording.significant(scale)} times; the longest is {wording.length(max(longest))}. Scale bar in "
            "the last "
            "panel."
        )
    columns = min(_COLUMNS, max(len(chosen), 4))
    picture = partial(drawing.draw_pose_sheet, content.runs, chosen, states, scale, columns)
    return ReportSection(_TITLE, (PictureBlock(picture, caption),))


def _distinct(content: ReportContent) -> list[int]:
    """Return the runs to choose from: the first of each pose."""
    poses: dict[tuple[float, ...], int] = {}
    for number, run in enumerate(content.runs):
        if run.stick is not None:
            poses.setdefault(tuple(np.round(run.joints, 2).tolist()), number)
    return list(poses.values())


def _chosen(numbers: list[int], longest: list[float]) -> list[int]:
    """Return the runs to draw, in their order: half those with the largest residuals, half evenly spread."""
    if len(numbers) <= _MOST_POSES:
        return numbers
    worst = sorted(numbers, key=lambda number: -longest[number])[: _MOST_POSES // 2]
    rest = [number for number in numbers if number not in worst]
    even = [rest[k] for k in np.linspace(0, len(rest) - 1, _MOST_POSES - len(worst)).round().astype(int)]
    return sorted([*worst, *even])


def _caption(n_chosen: int, n_all: int, has_residuals: bool) -> str:
    which = wording.count(n_all, "pose")
    if n_chosen < n_all:
        worst = f"the {_MOST_POSES // 2} with the largest residuals and others " if has_residuals else ""
        which = f"{n_chosen} of {n_all} poses, {worst}evenly spread"
    return f"{which}, viewed from the side and from above; circles: joints; grey: projection on the floor."
