"""Displacements or places of a run in another unit."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.load_units import INCH
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind

LENGTH_UNITS = (
    (1e3, "in m in a column of mm"),
    (1e-3, "in µm in a column of mm, or in mm in a column of m"),
    (1e3 * INCH, "in inches in a column of mm"),
    (1e-3 / INCH, "in mm in a column of inches"),
    (10.0, "in cm in a column of mm"),
    (0.1, "in mm in a column of cm"),
)


class DisplacementUnit(RunMistake):
    """Displacements, or places where these are measured, in another unit."""

    name = "displacement-unit"
    kind = SuspectKind.UNIT
    rank = 13

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with what was measured of its target multiplied."""
        own = read.own
        for factor, text in LENGTH_UNITS:
            words = f"are {text}: multiply by {factor:.5g}"
            if own.deflection_given:
                yield Variant(f"displacements {words}", factor, deflection=scaled(own.deflection, slice(0, 3), factor))
            else:
                yield Variant(f"places {words}", factor, position=own.position * factor)
