"""Targets that move by more under load than an arm gives: rows of a lost target, another unit, or another pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.tracker_axes import places_in_tracker
from stiffcal.reduction.logs.reading_bounds import LARGEST_DEFLECTION_M
from stiffcal.reduction.registration.still_components import lost_states, rounding_of
from stiffcal.wording import significant

MOST_NAMED = 10


def check_displacements(states: LoadStates, file: str) -> list[Fault]:
    """Return a fault for each run in which a target moved by more than a loaded arm can.

    Parameters
    ----------
    states : of load runs, those that are used. file : the manifest.
    """
    runs = members_of(states.run)
    far = np.flatnonzero(_moved_in(states.position, runs) > LARGEST_DEFLECTION_M)
    return [_fault_of(states.select(runs[number]), file) for number in far]


def _fault_of(run: LoadStates, file: str) -> Fault:
    largest = _moved(run)
    lost = lost_states(run)
    place = f"run {run.runs[int(run.run[0])].name}"
    reason = f"the target moved by {significant(largest)} m under load"
    mend = (
        'millimetres read as metres? write units = { position = "mm" }; or two poses in one run; rows of a '
        'lost target (−9999): [[exclude]], or rows = "X > -1000" under the source'
    )
    if lost.any() and not lost.all() and _moved(run.select(~lost)) <= LARGEST_DEFLECTION_M:
        numbers = np.unique(run.row[lost])
        stretches = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
        named = [f"{rows[0]}" if len(rows) == 1 else f"{rows[0]}-{rows[-1]}" for rows in stretches]
        more = f" and {len(named) - MOST_NAMED} more" if len(named) > MOST_NAMED else ""
        zero = np.asarray(np.abs(places_in_tracker(run)) <= rounding_of(run.position)).any(axis=(1, 2))
        reading = "zero" if (zero | ~lost).all() else "the same in every digit, far from the others,"
        reason = (
            f"the target's position, or a component of it, is {reading} in {len(numbers)} of {len(run)} states "
            f"({', '.join(named[:MOST_NAMED])}{more}): the target was lost, or the channel is dead"
        )
        mend = "measure these states again, or exclude them with [[exclude]]"
    return Fault(FaultCode.READING_IMPLAUSIBLE, file, place, reason, mend)


def _moved(run: LoadStates) -> float:
    """Return the largest difference of two readings of a component, m; zero where none was measured."""
    return float(_moved_in(run.position, [np.arange(len(run))])[0])


def _moved_in(position: Floats, runs: Sequence[Integers]) -> Floats:
    """Return (r,) of each run the largest difference of two readings of a component, m; zero where none was measured.

    Parameters
    ----------
    position : (n, t, 3) m, of targets; NaN where not measured. runs : the indices of r runs, none empty.
    """
    if not runs:
        return np.zeros(0)
    starts = np.cumsum([0, *(len(members) for members in runs[:-1])])
    ordered = position[np.concatenate(runs)]
    # fmax and fmin pass over what was not measured
    moved = np.fmax.reduceat(ordered, starts) - np.fmin.reduceat(ordered, starts)
    return np.asarray(np.nan_to_num(moved, nan=0.0).max(axis=(1, 2), initial=0.0))
