"""One mistake in many rows of absolute places: exchanged targets, or another unit.

With such rows the frames that most rows agree with are wrong themselves. The mean of the targets of one body does not
depend on their order, and shows the tracker's place; the targets' own places on the body then distinguish the rows.
Places in another unit are another distance from the origin: by more than those in one unit differ among themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.reduction.met_places import FAR, FAR_M, MeasuredPlaces, Met, meet, orders

MANIFEST = "campaign.toml"
LENGTH_FACTORS = {
    1e-3: "a thousand times too large",
    1e3: "a thousand times too small",
    1e-1: "ten times too large",
    1e1: "ten times too small",
    1e-2: "a hundred times too large",
    1e2: "a hundred times too small",
    25.4: "in inches",
    1.0 / 25.4: "in millimetres",
}
# Of some rows, the unit that the others have.
OTHER_UNIT = {25.4: " where the others are in millimetres", 1.0 / 25.4: " where the others are in inches"}
# Between two units the distances from the origin have a gap of this factor at least: least factor of two units is ten.
LEAST_GAP = 3.0
# Fewer rows with all targets do not determine the tracker's place well enough.
LEAST_ROWS = 10
ROUNDS = 10
MOST_LISTED = 6
# An uncalibrated robot misses by millimetres.
UNCALIBRATED_M = 5e-3


def exchanged_rows(states: LoadStates, places: MeasuredPlaces, far: Integers) -> Fault | None:
    """Return the fault of rows in which targets of one body are exchanged; None where that does not explain the places.

    Parameters
    ----------
    states : the rows. places : theirs. far : rows that are far from the others and have to meet with these.
    """
    n_targets = places.measured.shape[1]
    choices = [list(range(n_targets)), *orders(n_targets)]
    if len(choices) < 2 or not np.allclose(places.position, places.position[:, :1]):
        return None
    whole = np.flatnonzero(np.isfinite(places.measured).all(axis=(1, 2)))
    if len(whole) < LEAST_ROWS:
        return None
    middle = replace(
        places.at(whole),
        measured=places.measured[whole].mean(axis=1, keepdims=True),
        position=places.position[whole, :1],
        rotation=places.rotation[whole, :1],
        offset=places.offset.mean(axis=0, keepdims=True),
    )
    met = meet(middle)
    if met.usual(middle) > UNCALIBRATED_M:
        return None
    in_base = places.measured @ met.turn.T + met.shift - places.position
    on_body = np.einsum("nbji,nbj->nbi", places.rotation, in_base)
    reordered = np.stack([on_body[:, order] for order in choices])
    reference, chosen = on_body[whole[0]], np.zeros(len(on_body), dtype=np.int64)
    for _ in range(ROUNDS):
        updated = np.nansum((reordered - reference) ** 2, axis=(2, 3)).argmin(axis=0)
        reference = np.nanmedian(reordered[updated, np.arange(len(on_body))], axis=0)
        if np.array_equal(updated, chosen):
            break
        chosen = updated
    right = _right_order(chosen, [reference[np.argsort(order)] for order in choices], places.offset)
    wrong = np.flatnonzero(chosen != right)
    if not wrong.size:
        return None
    # each row's targets in the order that the right rows have
    to_right = np.array([np.array(order)[np.argsort(choices[right])] for order in choices])
    mended = replace(places, measured=places.measured[np.arange(len(on_body))[:, None], to_right[chosen]])
    if not _all_meet(meet(mended), mended, np.isin(np.arange(len(on_body)), np.union1d(wrong, far))):
        return None
    moved = [k for k in range(n_targets) if (to_right[chosen[wrong], k] != k).any()]
    *others, last = (states.setup.target_names[k] for k in moved)
    names = f"{', '.join(others)} and {last}"
    where = _where(states, wrong)
    reason = f"the positions of {names} are interchanged in {len(wrong)} of {len(on_body)} rows ({where})"
    mend = "interchange their columns there, or exclude these rows with [[exclude]]"
    return Fault(FaultCode.KINEMATICS_MISMATCH, MANIFEST, _place(states, wrong), reason, mend)


def _right_order(chosen: Integers, offsets: Sequence[Floats], stated: Floats) -> int:
    """Return which order is right: that in which the targets are where the manifest has them; else that of most rows.

    Parameters
    ----------
    chosen : (n,) the order of each row. offsets : (B, 3) m, where the targets are on the body for each order.
    stated : (B, 3) m.
    """
    present, counts = np.unique(chosen, return_counts=True)
    away = np.array([np.linalg.norm(offsets[order] - stated, axis=1).max() for order in present])
    if away.max() - away.min() > UNCALIBRATED_M:
        return int(present[away.argmin()])
    return int(present[counts.argmax()])


def rows_in_another_unit(states: LoadStates, places: MeasuredPlaces) -> Fault | None:
    """Return the fault of positions in another unit, of some rows or one target; None where that does not explain them.

    Parameters
    ----------
    states : the rows. places : theirs.
    """
    distance = np.linalg.norm(places.measured, axis=2)
    known = np.isfinite(distance) & (distance > 0.0)
    logs = np.sort(np.log(distance[known]))
    if len(logs) < LEAST_ROWS:
        return None
    gaps = np.diff(logs)
    widest = int(gaps.argmax())
    if gaps[widest] < np.log(LEAST_GAP):
        return None
    near = known & (np.log(np.where(known, distance, 1.0)) < 0.5 * (logs[widest] + logs[widest + 1]))
    far = known & ~near
    for factor, words in LENGTH_FACTORS.items():
        for other in (near, far):
            mended = replace(places, measured=np.where(other[:, :, None], factor * places.measured, places.measured))
            if _all_meet(meet(mended), mended, other.any(axis=1)):
                return _unit_fault(states, other, known, f"{words}{OTHER_UNIT.get(factor, '')}")
    return None


def _unit_fault(states: LoadStates, other: Booleans, known: Booleans, words: str) -> Fault:
    """Return the fault of the positions of ``other`` (n, B), of those that are ``known``."""
    rows = np.flatnonzero(other.any(axis=1))
    names = [states.setup.target_names[b] for b in np.flatnonzero(other.any(axis=0))]
    whole = bool((other == known)[rows].all())
    what = "positions" if whole else f"positions of {' and '.join(names)}"
    reason, place = f"the {what} are {words} in {len(rows)} of {len(other)} rows", f"poses.{names[0]}.units.position"
    mend = f"correct the unit of {'that target' if len(names) == 1 else 'these targets'}"
    if len(rows) < len(other):
        reason, place = f"{reason} ({_where(states, rows)})", _place(states, rows)
        mend = "correct the rows, or exclude them with [[exclude]]"
    return Fault(FaultCode.UNIT_IMPLAUSIBLE, MANIFEST, place, reason, mend)


def _all_meet(met: Met, places: MeasuredPlaces, mended: Booleans) -> bool:
    """Return whether the table meets, and nearly all of the rows that were mended."""
    usual = met.usual(places)
    if usual > UNCALIBRATED_M:
        return False
    away = np.nanmax(np.nan_to_num(met.distance(places)), axis=1)[mended]
    return bool(np.mean(away <= max(FAR * usual, FAR_M)) > 0.9)


def _place(states: LoadStates, rows: Integers) -> str:
    info = states.runs[int(states.run[rows[0]])]
    return f"run {info.of or info.name}, row {int(states.row[rows[0]])}" + (" and others" if len(rows) > 1 else "")


def _where(states: LoadStates, rows: Integers) -> str:
    """Return rows as they are counted in the table, those one after the other as from … to."""
    numbers = states.row[rows]
    breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
    pieces = [str(piece[0]) if len(piece) == 1 else f"{piece[0]} to {piece[-1]}" for piece in np.split(numbers, breaks)]
    more = len(pieces) - MOST_LISTED
    return ", ".join(pieces[:MOST_LISTED]) + (f" and {more} more places" if more > 0 else "")
