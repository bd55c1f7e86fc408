"""What `compensate` shows: the error along the path before and after, and the largest corrections."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import ANGLE, LENGTH, Units
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import angle, deviation, length, share

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stiffcal.compensation.compensate_result import CompensateResult
    from stiffcal.document_arrays import Vector
    from stiffcal.presentation.values import Page
    from stiffcal.show.options import ShowOptions

_WANTED = {
    "path": "wanted: the poses of the path, in base axes",
    "nominal robot": (
        "wanted: where robot.toml's rigid robot has {target} at the path's joint angles, in base axes; for angles that "
        "were taught on the robot itself: --no-sag"
    ),
    "unloaded robot": (
        "wanted: where the robot itself has {target} at the path's joint angles without the load, its sag and geometry "
        "errors included; to correct those too: --sag"
    ),
}
"""Which poses the errors count from."""


def page(result: CompensateResult, options: ShowOptions) -> Page:
    """Return the error along the path before and after, its uncertainty, and the largest corrections."""
    made = PageBuilder("Corrected path")
    made.say(f"{len(result.rows)} poses of {result.target}; values from {result.values_from}", "path")
    made.say(_WANTED[result.wanted].format(target=result.target), "wanted")
    judged = result.judged
    before, after = (_largest(errors) for errors in _errors(result))
    errors = [result.rms_before, result.rms_after, *((judged.rms_before, judged.rms_after) if judged else ())]
    units = Units([(LENGTH, [before, *(rms.translation for rms in errors)]), (ANGLE, [rms.rotation for rms in errors])])
    rows = [
        ("without compensation", deviation(result.rms_before, units), length(before, units)),
        ("with compensation, predicted by the model itself", deviation(result.rms_after, units), length(after, units)),
    ]
    if judged is not None:
        rows.append((f"without compensation, predicted by {judged.by}", deviation(judged.rms_before, units), ""))
        rows.append((f"with compensation, predicted by {judged.by}", deviation(judged.rms_after, units), ""))
    made.table(("", number("rms error"), number("largest")), rows)
    if result.residual_95 is not None:
        made.say(f"uncertainty of the correction: up to {length(result.residual_95)} (95 %)", "uncertainty")
    if judged is not None and judged.gone is not None:
        made.say(f"{share(judged.gone)} of the deflection is compensated, predicted by {judged.by}", "compensated")
    corrections = list(zip(result.largest_correction.tolist(), result.joint_units, strict=True))
    turns = [correction for correction, unit in corrections if unit == "deg"]
    moves = [correction for correction, unit in corrections if unit == "mm"]
    largest = [*([angle(max(turns))] if turns else []), *([length(max(moves))] if moves else [])]
    made.say("largest joint correction " + " and ".join(largest), "largest-correction")
    for file in (result.file, result.picture):
        if file is not None:
            made.say(f"wrote {file}", "written")
    return made.page()


def _errors(result: CompensateResult) -> tuple[list[Vector], list[Vector]]:
    return [row.error_before for row in result.rows], [row.error_after for row in result.rows]


def _largest(errors: Sequence[Vector]) -> float:
    """Return the largest length of the translations, m."""
    return max(float(sum(x * x for x in error[:3].tolist()) ** 0.5) for error in errors)
