"""What `map` shows: how much was reached, the ranges of what was mapped, where the worst point is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stiffcal.quantity import ANGLE, JOINT_ANGLE, LENGTH, LINEAR_STIFFNESS
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import fixed_places, in_unit, significant

if TYPE_CHECKING:
    from stiffcal.compensation.map_result import MapResult
    from stiffcal.presentation.values import Page
    from stiffcal.show.options import ShowOptions


def page(result: MapResult, options: ShowOptions) -> Page:
    """Return how much was reached, the smallest and largest of each quantity, the worst point, and what was written."""
    made = PageBuilder("Workspace")
    levels = ", ".join(significant(level) for level in result.levels)
    made.say(
        f"{result.target} in the {result.plane} plane at {levels} m: {result.reached} of {len(result.points)} points "
        f"reached, {result.beyond_limits} only beyond joint limits; values from {result.values_from}",
        "reached",
    )
    mapped = (
        ("position error", result.position_error, LENGTH),
        ("orientation error", result.orientation_error, ANGLE),
        ("stiffness", result.stiffness, LINEAR_STIFFNESS),
    )
    rows = [
        (name, *(in_unit(end, quantity.unit_for(ends)) for end in ends))
        for name, ends, quantity in mapped
        if ends is not None and ends[1] > 0.0
    ]
    made.table(("", number("smallest"), number("largest")), rows)
    worst = result.worst
    if worst is not None:
        place = ", ".join(fixed_places(LENGTH.usual.factor * value, 0) for value in worst.position)
        angles = [] if worst.joints is None else [fixed_places(math.degrees(turn), 1) for turn in worst.joints]
        joints = f", joints ({', '.join(angles)}){JOINT_ANGLE.usual.mark}" if angles else ""
        name = "largest position error" if any(result.wrench) else "softest point"
        made.say(f"{name} at ({place}) {LENGTH.usual.name} in base axes{joints}", "worst")
    for file in (result.file, result.picture):
        if file is not None:
            made.say(f"wrote {file}", "written")
    return made.page()
