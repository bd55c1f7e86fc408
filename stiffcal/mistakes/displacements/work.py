"""Loads and displacements that run against each other, with the single change of the manifest that fits.

Work of the load on the robot is positive; where it is not, or springs explain little, the load acts the other way, the
sensor is upside down, or its columns are interchanged. Columns and units of forces against moments are wrong where the
displacements need the load as it is without the mistake, and nothing of that as it is read (`chance_of_loads`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.catalogue.loads.load_units import LoadUnits
from stiffcal.mistakes.catalogue.loads.wrench_columns import WrenchColumns
from stiffcal.mistakes.displacements.springs import (
    BY_CHANCE,
    FOLLOWS,
    FOLLOWS_NOT,
    LEAST_POSES,
    chance_of_loads,
    count_distinct,
    count_loads,
    count_poses,
    explained_by_joints,
    left_by_joints,
    work_of_load,
)
from stiffcal.mistakes.inputs.mistake import AsRead, Scored, TriedOn
from stiffcal.mistakes.inputs.taken_back import taken_back
from stiffcal.mistakes.some_rows import MOST_ROWS, some_of
from stiffcal.wording import length

# In a few poses, which decide nothing by their scatter, another order of columns has to explain nearly all.
ORDER_EXPLAINS = 0.9
# Of places as many runs as give each of them some of the rows that are looked at.
ROWS_OF_RUN = 5
# By so much more than as it is read: a quarter is more than any effect but springs makes.
MUCH_MORE = 0.25
# What a turn of the whole load does not undo.
RELATIVE = (WrenchColumns.name, LoadUnits.name)


def check_work(
    states: LoadStates,
    chain: Chain,
    file: str = "campaign.toml",
    acts_on: str = "robot",
    place: str = "wrench",
    columns: tuple[str, ...] = (),
    units: tuple[str, ...] = (),
) -> list[Fault]:
    """Return a fault where force and deflection run against each other, with the mend that fits.

    Only runs that measure displacements count.

    Parameters
    ----------
    acts_on : what the manifest states now.
    place : the wrench's key in it.
    columns : of the wrench, 3 or 6. units : of its forces and moments, as the manifest states them.
    """
    displaced = np.array([run.measures is StateMeasure.DISPLACEMENT for run in states.runs], dtype=np.bool_)
    chosen = states.select(displaced[states.run] & states.used)
    if not np.any(chosen.wrench) or not chosen.setup.targets or count_distinct(chosen) < 2:
        return []
    sign = work_of_load(chosen, chain)
    present = np.unique(chosen.run)
    negative = int((sign.work[present] < 0.0).sum())
    read = AsRead(TriedOn.WORK, chosen, chain, _some_rows(chosen), columns=columns, acts_on=acts_on, load_units=units)
    tried = [Scored(explained_by_joints(taken.states, chain), taken) for taken in taken_back(read)]
    likeliest = max(tried, key=lambda one: one.score)
    if likeliest.taken.change.kind in RELATIVE and (
        _is_needed(likeliest, read, len(tried)) or _explains_nearly_all(likeliest, read, sign.explained)
    ):
        return [_relative_fault(likeliest, tried, read, file, place)]
    if 2 * negative <= present.size and sign.explained > FOLLOWS:
        return []
    best = max((one for one in tried if one.taken.change.kind not in RELATIVE), key=lambda one: one.score)
    if 2 * negative <= present.size and sign.explained > FOLLOWS_NOT:
        return []
    if best.score > FOLLOWS and best.score > sign.explained + MUCH_MORE:
        reason = f"force and deflection have opposite directions (negative work in {negative} of {present.size} runs)"
        return [_fault(best, tried, reason, file, place, chain)]
    if 2 * negative > present.size:
        reason = f"negative work in {negative} of {present.size} runs: force and deflection have opposite directions"
        return [
            Fault(
                FaultCode.WRENCH_MISMATCH,
                file,
                place,
                reason,
                "check acts_on, the sensor's frame and the displacement's axes",
            )
        ]
    return []


def _some_rows(states: LoadStates) -> Integers:
    """Return the rows that are looked at: of places several of each run, as their distances in it count."""
    if states.deflection_given:
        return some_of(len(states))
    present = np.unique(states.run)
    rows = np.flatnonzero(np.isin(states.run, present[some_of(len(present), MOST_ROWS // ROWS_OF_RUN)]))
    return rows[some_of(len(rows))]


def _explains_nearly_all(best: Scored, read: AsRead, explained: float) -> bool:
    """Return whether another order of columns explains nearly all, and the load as it is read or reversed does not."""
    if best.taken.change.kind != WrenchColumns.name or not _is_varied(read):
        return False
    against = explained_by_joints(replace(read.chosen, wrench=-read.chosen.wrench), read.chain)
    return best.score >= max(ORDER_EXPLAINS, explained + MUCH_MORE, against)


def _is_varied(read: AsRead) -> bool:
    return count_poses(read.chosen) >= LEAST_POSES and count_loads(read.chosen) >= LEAST_POSES


def _is_needed(best: Scored, read: AsRead, tried: int) -> bool:
    """Return whether displacements need what springs predict with another load, and not what they do as it is read."""
    if not _is_varied(read) or best.score <= FOLLOWS:
        return False
    needed, reverse = chance_of_loads(read.chosen, best.taken.states, read.chain)
    return needed * tried <= BY_CHANCE < reverse * tried


def _relative_fault(best: Scored, tried: list[Scored], read: AsRead, file: str, place: str) -> Fault:
    chain, mistake = read.chain, best.taken.mistake
    as_read, mended = (length(_left_m(one, chain)) for one in (read.chosen, best.taken.states))
    words = mistake.texts(mistake.as_known(best, tried), chain).words
    reason = f"joint springs leave {as_read} of the displacements with the load as it is read, {mended} with {words}"
    return _fault(best, tried, reason, file, place, chain)


def _left_m(states: LoadStates, chain: Chain) -> float:
    left, _ = left_by_joints(states, chain)
    return float(np.sqrt(np.mean(left**2)))


def _fault(best: Scored, tried: list[Scored], reason: str, file: str, place: str, chain: Chain) -> Fault:
    mistake, change = best.taken.mistake, best.taken.mistake.as_known(best, tried)
    texts = mistake.texts(change, chain)
    where = f"{place}{texts.place.removeprefix('wrench')}"
    return Fault(mistake.code, file, where, reason, texts.mend, changes=(change,))
