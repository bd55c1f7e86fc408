"""Joint moves from run to run: whether they are free, and through which poses where the direct one is not.

Ways lead through the possible poses, as in a probabilistic roadmap: L. E. Kavraki, P. Svestka, J.-C. Latombe, M. H.
Overmars, "Probabilistic roadmaps for path planning in high-dimensional configuration spaces", IEEE Trans. Robotics and
Automation 12, 1996; moves are checked when the search comes to them.
"""

from __future__ import annotations

import heapq
import itertools

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.planning.candidates import Cell, is_free

# Moves are checked at joint angles no further apart: at two metres the tip moves 35 mm, less than a link's radius.
MOVE_STEP = np.radians(1.0)
# Poses of the roadmap, and neighbours of each by the largest joint move.
ROADMAP = 300
NEIGHBOURS = 12


def move_is_free(chain: Chain, cell: Cell, tips: tuple[Attachment, ...], start: Floats, end: Floats) -> bool:
    """Return whether a joint move is free as `is_free` has it; all joints move in proportion.

    Parameters
    ----------
    start, end : (L,) logged angles, rad.
    """
    n_points = 2 + int(np.max(np.abs(end - start)) / MOVE_STEP)
    between = start + np.linspace(0.0, 1.0, n_points)[:, None] * (end - start)
    return bool(is_free(chain, cell, tips, between).all())


def ways_between(
    chain: Chain, cell: Cell, tips: tuple[Attachment, ...], joints: Floats, others: Floats
) -> list[Floats | None]:
    """Return for each move the poses (V, L) to drive through, none where the direct move is free.

    None where no way was found.

    Parameters
    ----------
    joints : (n, L) logged angles in the order of measuring, rad: n - 1 moves.
    others : (m, L) free poses that a way may lead through; the first `ROADMAP` are used.
    """
    # a pose may be measured twice, and runs are among the others
    poses, index = np.unique(np.concatenate([joints, others[:ROADMAP]]), axis=0, return_inverse=True)
    roadmap = _Roadmap(chain, cell, tips, poses)
    order = index.ravel()[: len(joints)].tolist()
    return [roadmap.way(start, end) for start, end in itertools.pairwise(order)]


class _Roadmap:
    """Poses, and the moves between neighbours that were checked so far."""

    def __init__(self, chain: Chain, cell: Cell, tips: tuple[Attachment, ...], poses: Floats) -> None:
        self._cell = chain, cell, tips
        self._poses = poses
        self._length = np.max(np.abs(poses[:, None] - poses[None]), axis=2)
        self._neighbours = np.argsort(self._length, axis=1, kind="stable")[:, : NEIGHBOURS + 1]
        self._free: dict[tuple[int, int], bool] = {}

    def _is_free(self, one: int, other: int) -> bool:
        pair = min(one, other), max(one, other)
        if pair not in self._free:
            self._free[pair] = move_is_free(*self._cell, self._poses[pair[0]], self._poses[pair[1]])
        return self._free[pair]

    def way(self, start: int, end: int) -> Floats | None:
        """Return the poses of the shortest way between two poses (Dijkstra), their own not among them."""
        if self._is_free(start, end):
            return np.zeros((0, self._poses.shape[1]))
        queue: list[tuple[float, int, int]] = [(0.0, start, start)]
        before: dict[int, int] = {}
        while queue:
            length, here, last = heapq.heappop(queue)
            if here in before or (last != here and not self._is_free(last, here)):
                continue
            before[here] = last
            if here == end:
                break
            for other in {*self._neighbours[here].tolist(), end} - set(before):
                heapq.heappush(queue, (length + float(self._length[here, other]), other, here))
        if end not in before:
            return None
        passed = [before[end]]
        while before[passed[-1]] != passed[-1]:
            passed.append(before[passed[-1]])
        return np.asarray(self._poses[passed[-2::-1]])
