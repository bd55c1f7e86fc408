"""Pairs of a pose and a direction of load that a plan chooses from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers

FEWER = "take fewer candidates, directions, steps or cycles, or raise STIFFCAL_MAX_PLANNED"


@dataclass(frozen=True)
class Candidates:
    """N pairs of a possible pose and a direction of load."""

    joints: Floats
    """(N, L) rad."""
    wrench: Floats
    """(N, K, 6) the load steps."""
    turn: Floats | None = None
    """(N, K, L) rad, how far logged joints' motors are driven at these steps; None but for clamped robots."""

    def subset(self, chosen: Integers) -> Candidates:
        """Return some of them."""
        return Candidates(self.joints[chosen], self.wrench[chosen], None if self.turn is None else self.turn[chosen])

    def with_others(self, others: Candidates) -> tuple[Candidates, Integers]:
        """Return these with the others that are not among them, and the places of all the others."""
        rows, theirs = (
            np.concatenate([table.reshape(len(table), -1) for table in entry.tables], axis=1)
            for entry in (self, others)
        )
        places = {row.tobytes(): k for k, row in reversed(list(enumerate(rows)))}
        further: list[int] = []
        for k, row in enumerate(theirs):
            if places.setdefault(row.tobytes(), len(rows) + len(further)) == len(rows) + len(further):
                further.append(k)
        return self + others.subset(np.array(further, dtype=np.int64)), np.array(
            [places[row.tobytes()] for row in theirs]
        )

    @property
    def tables(self) -> tuple[Floats, ...]:
        """All that distinguishes runs, N rows each."""
        return (self.joints, self.wrench) if self.turn is None else (self.joints, self.wrench, self.turn)

    def __add__(self, others: Candidates) -> Candidates:
        pairs = zip(self.tables, others.tables, strict=True)
        return Candidates(*(np.concatenate([own, other]) for own, other in pairs))
