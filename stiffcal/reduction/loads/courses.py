"""Readings of one run, direction and branch, and their smooth course over load."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers

LIKE_LOAD = 0.08  # of the run's largest load, as in load_cycles


@dataclass(frozen=True)
class Group:
    """Readings of one run, direction and branch: indices (m,) into the states, load (m,) as a share of the largest."""

    members: Integers
    load: Floats
    loaded: bool
    direction: int


@dataclass(frozen=True)
class AlikeCourses:
    """Groups of equally many readings whose smooth courses have equally many columns: thousands are taken at once."""

    groups: list[int]
    """Their g numbers."""
    members: Integers
    """(g, m) the readings of each."""
    course: Floats
    """(g, m, p) as `smooth_course` gives it."""

    def left(self, readings: Floats) -> tuple[Floats, Floats]:
        """Return (g, m, k) what the courses leave of readings (n, k), and (g, m) the diagonals of the hat matrices."""
        across, own = np.linalg.qr(self.course)[0], readings[self.members]
        left = own - across @ (np.swapaxes(across, 1, 2) @ own)
        return np.asarray(left), np.asarray((across**2).sum(axis=2))


def alike_courses(groups: Sequence[Group], kept: Booleans) -> Iterator[AlikeCourses]:
    """Yield the smooth courses of all groups that have one, as `smooth_course` gives them, alike ones together.

    Parameters
    ----------
    groups : of all runs. kept : (n,) the readings that count.
    """
    of_size: dict[tuple[int, bool], list[tuple[int, Integers, Floats]]] = {}
    for number, group in enumerate(groups):
        mask = kept[group.members]
        members = group.members[mask]
        of_size.setdefault((members.size, group.loaded), []).append((number, members, group.load[mask]))
    for (_, loaded), entries in of_size.items():
        columns = _columns_of_courses(np.stack([load for _, _, load in entries]), loaded)
        for count in np.unique(columns[columns > 0]).tolist():
            chosen = [entries[k] for k in np.flatnonzero(columns == count)]
            load = np.stack([load for _, _, load in chosen])
            course = np.stack([load**power for power in range(count - 1, -1, -1)], axis=2)
            members = np.stack([members for _, members, _ in chosen])
            yield AlikeCourses([number for number, _, _ in chosen], members, course)


def _columns_of_courses(load: Floats, loaded: bool) -> Integers:
    """Return (g,) the number of columns of the smooth courses over loads (g, m): constant, line, parabola; 0: none."""
    groups, size = load.shape
    if not loaded:
        return np.full(groups, 1 if size >= 3 else 0)
    levels = 1 + (np.diff(np.sort(load, axis=1), axis=1) > LIKE_LOAD).sum(axis=1)
    columns = np.minimum(2 if size >= 6 else 1, levels - 1) + 1
    return np.where((levels < 2) | (size < 4), 0, columns)


def basis_of(course: Floats) -> Floats:
    """Return (m, p) an orthonormal basis of the columns of a course (m, p): its square is the hat matrix."""
    return np.asarray(np.linalg.qr(course)[0])


def smooth_course(group: Group, kept: Booleans) -> Floats | None:
    """Return the design (m, p) of a smooth course over load: constant, line or parabola by the readings there are."""
    load = group.load[kept]
    columns = int(_columns_of_courses(load[None], group.loaded)[0])
    return np.vander(load, columns) if columns else None
