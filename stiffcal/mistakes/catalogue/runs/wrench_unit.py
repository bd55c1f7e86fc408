"""Forces and moments of a run in other units."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.load_units import FOOT, FORCE_FACTORS, INCH, LBF
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant
from stiffcal.mistakes.suspect_kinds import SuspectKind

# Two factors at once are a mistake on two columns: it is taken where it explains a run clearly better than one factor,
# by odds of seven (the squared misfit is twice the logarithm).
TWO_FACTORS = 4.0
# Forces and moments by their usual pairs of units.
PAIRS = (("lbf and lbf·in", LBF, LBF * INCH), ("lbf and lbf·ft", LBF, LBF * FOOT))


class WrenchUnit(RunMistake):
    """Forces and moments in other units, both by one factor or each in its unit of a pair."""

    name = "wrench-unit"
    kind = SuspectKind.UNIT
    rank = 11

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with both multiplied."""
        if not read.own.setup.moments_measured:
            return
        choices = [(factor, factor, f"{text}: multiply both by {factor:.5g}") for factor, text in FORCE_FACTORS]
        choices += [
            (force, moment, f"are in {units}: multiply by {force:.5g} and {moment:.5g}")
            for units, force, moment in PAIRS
        ]
        for force, moment, words in choices:
            wrench = read.own.wrench * np.repeat([force, moment], 3)
            yield Variant(f"forces and moments {words}", force, wrench=wrench, penalty=TWO_FACTORS)
