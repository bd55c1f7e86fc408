"""How often a run may be repeated: runs that are near-copies of each other count as the same one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers


class TooAlikeError(Exception):
    """Of the candidates too few differ.

    Attributes
    ----------
    found : how many runs differ as they should.
    """

    def __init__(self, found: int) -> None:
        super().__init__(f"{found} candidates differ")
        self.found = found


@dataclass(frozen=True)
class Repeats:
    """A limit on like candidates."""

    most: int
    """How often runs that are alike may be measured, all of them together."""
    joints: Floats | None = None
    """(N, L) rad of the candidates; None: each is like itself alone."""
    load: Integers | None = None
    """(N,) equal where all else that distinguishes runs is: their loads, or the driven joint."""
    near: float = 0.0
    """Poses are alike where no joint's angles differ by more, rad."""
    _found: dict[int, Booleans] = field(default_factory=dict, init=False, repr=False, compare=False)

    @staticmethod
    def of(limit: Repeats | int | None, n_runs: int) -> Repeats:
        """Return a limit: a number counts equal candidates, None is no limit."""
        if isinstance(limit, Repeats):
            return limit
        return Repeats(n_runs if limit is None else limit)

    def subset(self, picked: Integers) -> Repeats:
        """Return the limit on some of the candidates."""
        if self.joints is None or self.load is None:
            return self
        return replace(self, joints=self.joints[picked], load=self.load[picked])

    def exhausted(self, design: Integers, n_candidates: int) -> Booleans:
        """Return (N,) True for candidates of whose like the design has as many as are allowed."""
        if self.joints is None or self.load is None:
            count = np.bincount(design, minlength=n_candidates)
        else:
            count = np.zeros(n_candidates, dtype=np.int64)
            for candidate in design.tolist():
                count += self._like(candidate)
        return np.asarray(count >= self.most)

    def _like(self, candidate: int) -> Booleans:
        """Return (N,) True for candidates like one of them. Found once: a design asks again for each exchange."""
        if candidate not in self._found:
            assert self.joints is not None
            assert self.load is not None
            turned = self.joints - self.joints[candidate]  # a whole turn leads to the same pose
            apart = np.abs(turned - 2.0 * np.pi * np.round(turned / (2.0 * np.pi))).max(axis=1)
            self._found[candidate] = (apart <= self.near) & (self.load == self.load[candidate])
        return self._found[candidate]

    def kept(self, design: Sequence[int] | Integers, n_runs: int, order: Integers) -> Integers:
        """Return a design as far as it keeps the limit, filled up with the candidates in some order.

        Raises
        ------
        TooAlikeError : there are not enough that differ.
        """
        chosen: list[int] = []
        n_candidates = len(order)
        for candidate in (*design, *np.tile(order, self.most)):
            if len(chosen) == n_runs:
                break
            if not self.exhausted(np.array(chosen, dtype=np.int64), n_candidates)[candidate]:
                chosen.append(int(candidate))
        if len(chosen) < n_runs:
            raise TooAlikeError(len(chosen))
        return np.array(chosen, dtype=np.int64)
