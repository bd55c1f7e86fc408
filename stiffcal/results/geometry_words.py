"""The geometry that was found, as a table and in sentences: for the terminal and the report alike."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stiffcal.identification.answers.geometry_results import (
    GeometryFound,
    NoOffsets,
    StatedLink,
    StatedNumber,
    StatedZero,
)
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import listing, plus_minus, significant

FRAME = "frame"
"""The effect of poses of frames that the fit finds."""
IN_ROWS = "link-geometry"
"""The effect whose parameters the rows of the geometry state in another form."""
HEADER = (
    ("joint", ""), ("offset to enter", "°"), ("θ", "°"), ("d", "mm"), ("a", "mm"), ("α", "°"), ("β", "°")
)  # fmt: skip
"""Titles and units of `table_rows`."""
CONVENTIONS = {"dh": "Denavit-Hartenberg", "modified-dh": "modified Denavit-Hartenberg (Craig)"}
"""In words."""
MOST_CAUSES = 4
"""A number that hangs together with more others is one of a set that these poses do not determine."""
_MILLIMETRES, _DEGREES = 1e3, math.degrees(1.0)


def table_rows(found: GeometryFound) -> list[tuple[str, ...]]:
    """Return a row of cells for each joint: value ± 95 %, a value alone where it is a choice, "–" where none is."""
    beta = {entry.joint: entry.beta for entry in found.beta}
    return [
        (
            str(zero.joint),
            _offset(zero, link),
            _cell(zero.theta, _DEGREES),
            _cell(link.d, _MILLIMETRES),
            _cell(link.a, _MILLIMETRES),
            _cell(link.alpha, _DEGREES),
            _cell(beta.get(zero.joint), _DEGREES),
        )
        for zero, link in zip(found.zeros, found.links, strict=True)
    ]


def _offset(zero: StatedZero, link: StatedLink) -> str:
    """Return the offset to enter: degrees, of a prismatic joint mm with the unit."""
    if (link.d if zero.prismatic else zero.theta).std is None:
        return "–"
    if zero.prismatic:
        return f"{significant(_MILLIMETRES * zero.logged)} mm".replace("-", "−")
    return significant(_DEGREES * zero.logged).replace("-", "−")


def convention_in_words(found: GeometryFound) -> str:
    """Return how the rows are to be read."""
    return (
        f"geometry as rows of {CONVENTIONS[found.convention]}, ± 95 %; a value without ± is a convention, valid with "
        "the others"
    )


def sentences(found: GeometryFound) -> Iterator[str]:
    """Yield what is a choice and why, and what offsets alone would leave."""
    yield from _choices(found)
    left = found.offsets_alone
    prismatic = [str(zero.joint) for zero in found.zeros if zero.prismatic]
    if prismatic:
        yield (
            f"a shift of the axis of prismatic joint {listing(prismatic)} across itself changes no motion: only its "
            "direction is found, and the numbers that place it are conventions"
        )
    if left is None:
        why = {
            NoOffsets.BEYOND_RANGE: "the best ones exceed half a turn or the range of a joint",
            NoOffsets.NO_SMALLER_ERROR: "the best ones leave no smaller error",
            NoOffsets.NOT_CONVERGED: "the iteration for the best ones does not converge",
        }[found.no_offsets or NoOffsets.NO_SMALLER_ERROR]
        yield f"no offsets for a controller that takes only offsets: {why}"
        return
    if prismatic:
        in_words = [
            f"{_MILLIMETRES * value:.4f} mm" if zero.prismatic else f"{_DEGREES * value:.4f}°"
            for value, zero in zip(left.zeros, found.zeros, strict=True)
        ]
        zeros = ", ".join(in_words).replace("-", "−")
    else:
        zeros = ", ".join(f"{_DEGREES * zero:.4f}" for zero in left.zeros).replace("-", "−") + "°"
    mean, rms, worst = (f"{significant(_MILLIMETRES * distance)} mm" for distance in (left.mean, left.rms, left.max))
    yield (
        f"a controller that takes only offsets: add {zeros} to the logged angles; this leaves {mean} mean, {rms} rms, "
        f"{worst} at worst over the measured poses"
    )


def _choices(found: GeometryFound) -> Iterator[str]:
    """Yield which numbers are a choice, and what they cannot be separated from."""
    by_cause: dict[str, list[str]] = {}
    together = []
    for name, number in _numbers(found):
        causes = number.cannot_be_separated_from
        if causes and len(causes) <= MOST_CAUSES:
            by_cause.setdefault(listing(causes), []).append(name)
        elif causes:
            together.append(name)
    if by_cause:
        pairs = "; ".join(f"{listing(names)} from {cause}" for cause, names in by_cause.items())
        yield f"these poses do not separate {pairs}"
    if together:
        yield f"these poses do not separate {listing(together)} from each other: measure more poses"


def _numbers(found: GeometryFound) -> Iterator[tuple[str, StatedNumber]]:
    for zero, link in zip(found.zeros, found.links, strict=True):
        of_row = (("θ", zero.theta), ("d", link.d), ("a", link.a), ("α", link.alpha))
        yield from ((f"{name} of joint {zero.joint}", number) for name, number in of_row if number is not None)
    for entry in found.beta:
        yield f"β of joint {entry.joint}", entry.beta


def _cell(number: StatedNumber | None, factor: float) -> str:
    if number is None:
        return "–"
    if number.std is None:
        return f"{round(factor * number.value, 4):g}".replace("-", "−")
    return plus_minus(factor * number.value, factor * NORMAL_95 * number.std)
