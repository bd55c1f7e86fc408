"""Exchanged targets in many rows of absolute places.

With such rows the frames that most rows agree with are wrong themselves. The mean of the targets of one body does not
depend on their order, and shows the tracker's place; the targets' own places on the body then distinguish the rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.errors import Fault
from stiffcal.fault_changes import InputChange
from stiffcal.mistakes.absolute.met_places import (
    EXPLAINED,
    LEAST_ROWS,
    UNCALIBRATED_M,
    MeasuredPlaces,
    Met,
    far_from,
    meet,
    orders,
)
from stiffcal.mistakes.absolute.table_rows import TableRows
from stiffcal.mistakes.catalogue.positions.target_order import TargetOrder
from stiffcal.mistakes.words import listed

# The orders of the rows and the targets' places on the body by turns: they are at rest in a few rounds, or never.
MOST_ROUNDS = 100


def exchanged_rows(table: TableRows, places: MeasuredPlaces, far: Integers) -> Fault | None:
    """Return the fault of rows in which targets of one body are exchanged; None where that does not explain the places.

    Parameters
    ----------
    table : the rows. places : theirs. far : rows that are far from the others and have to meet with these.
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
    if not met.settled or met.usual(middle) > UNCALIBRATED_M:
        return None
    in_base = places.measured @ met.turn.T + met.shift - places.position
    on_body = np.einsum("nbji,nbj->nbi", places.rotation, in_base)
    reference, chosen = on_body[whole[0]], np.zeros(len(on_body), dtype=np.int64)
    for _ in range(MOST_ROUNDS):
        # one order at a time: all of five targets are 120 times the table
        away = [np.nansum((on_body[:, order] - reference) ** 2, axis=(1, 2)) for order in choices]
        updated = np.argmin(away, axis=0)
        reordered = on_body[np.arange(len(on_body))[:, None], np.array(choices)[updated]]
        reference = np.nanmedian(reordered, axis=0)
        if np.array_equal(updated, chosen):
            break
        chosen = updated
    else:
        # rows that keep changing their order have none in which their targets agree
        return None
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
    names = tuple(table.states.setup.target_names[k] for k in moved)
    where = table.listed(wrong)
    reason = f"the positions of {listed(names)} are interchanged in {len(wrong)} of {len(on_body)} rows ({where})"
    mend = f"interchange their columns there, or exclude these rows with {table.exclusion(wrong)}"
    change = InputChange(TargetOrder.name, names)
    file, place, rows = table.file(int(wrong[0])), table.place(wrong), table.numbers(wrong)
    return Fault(TargetOrder.code, file, place, reason, mend, changes=(change,), rows=rows)


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


def _all_meet(met: Met, places: MeasuredPlaces, mended: Booleans) -> bool:
    """Return whether the table meets, and nearly all of the rows that were mended."""
    usual = met.usual(places)
    if not met.settled or usual > UNCALIBRATED_M:
        return False
    away = np.nanmax(np.nan_to_num(met.distance(places)), axis=1)[mended]
    return bool(np.mean(away <= far_from(usual)) > EXPLAINED)
