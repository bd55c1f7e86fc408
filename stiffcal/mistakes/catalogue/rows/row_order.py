"""Columns that stand some rows too high or too low against the others, or in reverse order.

A joint with a memory (play, creep, friction) lags behind its load as if rows of a pose were moved. The rows next to
another pose distinguish the two: there, too, displacements have to follow their loads better.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.fault_changes import InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import SAME_ANGLES_RAD, explained_by_joints, is_better
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TakenBack, TriedOn, Way

# A title, a line of units and one of numbers above the columns of one of two tables that were put next to each other.
MOST_ROWS_MOVED = 3


class RowOrder(InputMistake):
    """Places, displacements or loads of other rows."""

    name = "row-order"
    part = InputPart.ROWS
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.DISPLACEMENTS})
    rank = 70

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield columns some rows further down or up, and places reversed; rows that none reaches are left out."""
        if read.tried_on is TriedOn.DISPLACEMENTS:
            for by in _steps(MOST_ROWS_MOVED):
                for moved in ("displacements", "loads"):
                    yield Way(_moved(read.states, _inner(read, by), by, moved), (moved,), (float(by),))
            return
        position = read.states.position
        for by in _steps(min(MOST_ROWS_MOVED, len(position) - 1)):
            shifted = np.full_like(position, np.nan)
            if by > 0:
                shifted[by:] = position[:-by]
            else:
                shifted[:by] = position[-by:]
            yield Way(replace(read.chosen, position=shifted[read.rows]), ("positions",), (float(by),))
        yield Way(replace(read.chosen, position=position[::-1][read.rows]), ("positions",))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (moved,), place = change.names, "the order of the rows"
        if not change.sizes:
            mend = f"reverse the rows of the {moved} against those of the other columns"
            return ChangeTexts(place, f"the order of the {moved} reversed", mend)
        (size,) = change.sizes
        rows = "one row" if abs(size) == 1.0 else f"{abs(size):.0f} rows"
        by = f"{'down' if size > 0.0 else 'up'} by {rows}"
        mend = f"move the columns of the {moved} {by} against the other columns"
        return ChangeTexts(place, f"all {moved} moved {by}", mend)

    def is_distinct(self, read: AsRead, taken: TakenBack) -> bool:
        """Return whether those displacements follow their loads better, too, that belong to another pose than it seems.

        That is, displacements or loads which would be those of another pose than their row's.
        """
        if read.tried_on is not TriedOn.DISPLACEMENTS:
            return True
        (moved,), by, states = taken.change.names, int(taken.change.sizes[0]), read.states
        inner = _inner(read, by)
        of_others = np.any(np.abs(states.joints[inner + by] - states.joints[inner]) > SAME_ANGLES_RAD, axis=1)
        edges = inner[of_others]
        if not len(edges):
            return False
        as_read = explained_by_joints(states.select(edges), read.chain)
        at_edges = _moved(states, edges + by if moved == "displacements" else edges, by, moved)
        return is_better(as_read, explained_by_joints(at_edges, read.chain), at_edges, read.chain)


def _steps(most: int) -> Iterator[int]:
    """Yield by how many rows, the likelier ones first."""
    for number in range(1, most + 1):
        yield from (number, -number)


def _inner(read: AsRead, by: int) -> Integers:
    """Return the rows that are looked at which have others so many rows above and below."""
    rows = read.rows
    return rows[(np.minimum(rows - by, rows + by) >= 0) & (np.maximum(rows - by, rows + by) < len(read.states))]


def _moved(states: LoadStates, rows: Integers, by: int, moved: str) -> LoadStates:
    """Return some rows with the displacements or the loads that stand so many rows further up."""
    read = states.select(rows)
    if moved == "loads":
        return replace(read, wrench=states.wrench[rows - by])
    return replace(read, deflection=states.deflection[rows - by])
