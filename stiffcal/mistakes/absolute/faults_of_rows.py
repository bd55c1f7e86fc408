"""Rows of absolute places that do not meet the others: the rows of one mistake in one line.

Angles and positions of the rows are changed as by the mistakes that people make; a change with which they meet the
others names theirs. What no change explains may be places of other rows, or rows that agree with each other: then the
tracker, the base or a target was moved.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import Fault
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.mistakes.absolute.met_places import (
    EXPLAINED,
    FAR_M,
    LEAST_ROWS,
    MEETS,
    MEETS_M,
    MeasuredPlaces,
    Met,
    far_from,
    meet,
)
from stiffcal.mistakes.absolute.places import undone
from stiffcal.mistakes.absolute.table_rows import TableRows
from stiffcal.mistakes.catalogue.frames.tracker_frame import MisplacedTracker
from stiffcal.mistakes.catalogue.rows.pose_order import PoseOrder
from stiffcal.mistakes.inputs.mistake import AsRead, InputPart, TriedOn
from stiffcal.mistakes.inputs.taken_back import taken_back
from stiffcal.mistakes.stated_units import stated_units
from stiffcal.quantity import LENGTH
from stiffcal.wording import length, significant

# Lines of a terminal that a person reads; the others are counted.
MOST_NAMED = 4
# Where many rows are wrong and some remain without a cause, no more than so many of all may be wrong: of more the
# right ones may be those that are called wrong.
MOST_WRONG = 0.6
# Other rows with the mistake are looked for where the table has no more than so many times the wrong rows (time).
MOST_TIMES = 20


@dataclass(frozen=True)
class SomeRows:
    """The rows that do not meet the others."""

    table: TableRows
    """All rows."""
    places: MeasuredPlaces
    """Theirs."""
    met: Met
    """Frames with which the others meet."""
    usual: float
    """m, the others' median distance."""
    wrong: Integers
    """(w,) the rows that do not meet."""
    many: bool
    """Whether they are too many for mistakes of single rows."""

    def distance(self, places: MeasuredPlaces) -> Floats:
        """Return (n,) m, by how much changed places of rows miss, the worst target."""
        return self.met.worst(places)

    @property
    def near(self) -> float:
        """Return the distance in m within which a row meets the others."""
        return max(MEETS * self.usual, MEETS_M)


@dataclass(frozen=True)
class _Group:
    """Rows of one mistake."""

    rows: Integers
    code: FaultCode
    reason: str
    mend: str = ""
    of_angles: bool = False
    change: InputChange | None = None
    """With which the rows meet the others; None where none is known."""
    undecided: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(u,) other rows, which meet with its correction too, and without it are not far enough off to be named."""


def faults_of_rows(some: SomeRows) -> list[Fault]:
    """Return one fault for the rows of each mistake; none where too many rows remain without a cause."""
    groups = _by_changes(some)
    if all(len(group.rows) < EXPLAINED * len(some.wrong) for group in groups):
        moved = _moved(some, some.wrong)
        groups = [moved] if moved is not None else groups
    named = np.concatenate([group.rows for group in groups]) if groups else some.wrong[:0]
    left = np.setdiff1d(some.wrong, named)
    if (
        some.many
        and len(left) > (1.0 - EXPLAINED) * len(some.wrong)
        and (len(some.wrong) > MOST_WRONG * len(some.places.measured))
    ):
        return []
    groups += _without_change(some, left)
    groups.sort(key=lambda group: int(group.rows[0]))
    faults = [_fault(some, group) for group in groups]
    if len(groups) > MOST_NAMED:
        code, file = FaultCode.MORE_FAULTS, faults[0].file
        more = some.table.numbers(np.concatenate([group.rows for group in groups[MOST_NAMED:]]))
        faults = [*faults[:MOST_NAMED], Fault(code, file, "", f"{len(more)} more rows", "as above", rows=more)]
    return faults


def _fault(some: SomeRows, group: _Group) -> Fault:
    table, one = some.table, len(group.rows) == 1
    correct, exclude = ("correct the row", "exclude it") if one else ("correct the rows", "exclude them")
    mend = group.mend or f"{correct}, or {exclude} with {table.exclusion(group.rows)}"
    count = f" in {len(group.rows)} of {len(table.states)} rows ({table.listed(group.rows)})"
    if len(group.undecided):
        row = "row" if len(group.undecided) == 1 else "rows"
        limit = length(far_from(some.usual), digits=2)
        count += f", and perhaps in {row} {table.listed(group.undecided)}, off by less than {limit}"
    return Fault(
        group.code,
        table.file(int(group.rows[0]), of_angles=group.of_angles),
        table.place(group.rows, of_angles=group.of_angles),
        group.reason + ("" if one else count),
        mend,
        changes=() if group.change is None else (group.change,),
        rows=table.numbers(group.rows),
    )


def _by_changes(some: SomeRows) -> list[_Group]:
    """Return the rows that a change explains, the change of the most rows first."""
    table, rows = some.table, some.wrong
    n = len(table.states)
    looked_at = np.arange(n) if len(rows) > 1 and n <= MOST_TIMES * len(rows) else rows
    own = np.isin(looked_at, rows)
    groups, explained = [], []
    # one change at a time: all of them are a hundred times the rows
    campaign = table.campaign
    read = AsRead(TriedOn.ABSOLUTE_ROWS, table.states, campaign.chain, looked_at, stated_units(campaign))
    places = some.places.at(looked_at)
    for taken in taken_back(read):
        met = some.distance(undone(read, places, taken)) <= some.near
        mistake, reason = taken.mistake, taken.mistake.texts(taken.change, campaign.chain).in_rows
        of_angles, either = mistake.part is InputPart.ANGLES, looked_at[met & ~own]
        groups.append(_Group(rows, mistake.code, reason, "", of_angles, taken.change, either))
        explained.append(met[own])
    left, found = np.array(explained), []
    while left.any():
        k = int(left.sum(axis=1).argmax())
        found.append(replace(groups[k], rows=rows[left[k]]))
        left &= ~left[k]
    return found


def _without_change(some: SomeRows, left: Integers) -> list[_Group]:
    """Return groups of the rows that no change explains."""
    code, groups = FaultCode.KINEMATICS_MISMATCH, []
    missed = some.distance(some.places)
    for k in left.copy():
        twin = _twin(some, int(k))
        if twin is not None:
            reason = (
                f"it has exactly the joint angles of row {int(some.table.states.row[twin])}, but its position is "
                f"{length(missed[k])} away"
            )
            groups.append(_Group(np.array([k]), code, reason, of_angles=True))
            left = left[left != k]
    fitting = _rows_that_fit(some, left)
    strange = np.flatnonzero(fitting >= 0)
    if strange.size:
        numbers = some.table.states.row
        pairs = [f"of row {int(numbers[left[i]])} those of row {int(numbers[fitting[i]])}" for i in strange[:2]]
        reason = f"the position meets the joint angles of another row ({', '.join(pairs)})"
        names = tuple(str(numbers[k]) for i in strange for k in (left[i], fitting[i]))
        change = InputChange(PoseOrder.name, names)
        mend = "put each position next to its joint angles"
        groups.append(_Group(left[strange], code, reason, mend, change=change))
        left = left[fitting < 0]
    if not left.size:
        return groups
    others = f"the others' {length(some.usual, digits=2)}"
    if len(left) == 1:
        reason = f"its position is {length(missed[left[0]])} from where its joint angles put it, {others}"
        groups.append(_Group(left, code, reason))
    else:
        low, high = LENGTH.usual.factor * missed[left].min(), LENGTH.usual.factor * missed[left].max()
        reason = (
            f"the position is {significant(low)} to {significant(high)} {LENGTH.usual.name} from where the joint "
            f"angles put it, {others},"
        )
        groups.append(_Group(left, code, reason))
    return groups


def _twin(some: SomeRows, k: int) -> int | None:
    """Return another row with exactly the joint angles of row k."""
    joints = some.table.states.joints
    twins = np.flatnonzero((np.abs(joints - joints[k]).max(axis=1) == 0.0) & (np.arange(len(joints)) != k))
    return int(twins[0]) if twins.size else None


def _rows_that_fit(some: SomeRows, left: Integers) -> Integers:
    """Return (w,) the rows whose joint angles the positions of rows ``left`` meet; −1 where there is none."""
    places, met = some.places, some.met
    expected = places.position + np.einsum("nbij,bj->nbi", places.rotation, met.offset)
    found = np.full(len(left), -1, dtype=np.int64)
    for i, k in enumerate(left):
        measured = places.measured[k] @ met.turn.T + met.shift
        away = np.nanmax(np.linalg.norm(measured - expected, axis=2), axis=1)
        nearest = int(away.argmin())
        if nearest != k and away[nearest] <= some.near:
            found[i] = nearest
    return found


def _moved(some: SomeRows, left: Integers) -> _Group | None:
    """Return what moved in rows that do not meet the others but each other; None where they do not."""
    if len(left) < LEAST_ROWS:
        return None
    places = some.places.at(left)
    own = meet(places)
    if not own.settled or np.mean(own.worst(places) <= max(some.near, FAR_M)) < EXPLAINED:
        return None
    # where the tracker was before, in its own axes then: of the base or of the tracker is the same
    turn = some.met.turn.T @ own.turn
    angle = float(np.degrees(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))))
    centre = np.nanmean(places.measured, axis=(0, 1))
    shift = (own.turn - some.met.turn) @ centre + own.shift - some.met.shift
    offset = float(np.linalg.norm(own.offset - some.met.offset, axis=1).max())
    reason = (
        f"the positions meet the joint angles with the tracker, the base or a target moved (tracker or base by "
        f"{length(float(np.linalg.norm(shift)))} and {significant(angle, 2)}°, targets by {length(offset, digits=2)})"
    )
    mend = f"exclude them with {some.table.exclusion(left)}, or make a campaign of their own of them"
    sizes = (*vector_from_rotation(turn).tolist(), *shift.tolist())
    change = InputChange(MisplacedTracker.name, sizes=sizes)
    return _Group(left, FaultCode.KINEMATICS_MISMATCH, reason, mend, change=change)
