"""Loads and displacements that run against each other, with the single change of the manifest that fits.

Work of the load on the robot is positive; where it is not, or springs explain little, the load acts the other way, the
sensor is upside down, or the force's columns are interchanged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.catalogue.loads.wrench_columns import WrenchColumns
from stiffcal.mistakes.displacements.springs import (
    FOLLOWS,
    FOLLOWS_NOT,
    LEAST_POSES,
    count_distinct,
    count_loads,
    explained_by_joints,
    work_of_load,
)
from stiffcal.mistakes.inputs.mistake import AsRead, Scored, TriedOn
from stiffcal.mistakes.inputs.taken_back import taken_back

# Another order of the force's columns has to explain nearly all: of five others one explains much by chance.
ORDER_EXPLAINS = 0.9
# By so much more than as it is read: a quarter is more than any effect but springs makes.
MUCH_MORE = 0.25


def check_work(
    states: LoadStates,
    chain: Chain,
    file: str = "campaign.toml",
    acts_on: str = "robot",
    place: str = "wrench",
    columns: tuple[str, ...] = (),
) -> list[Fault]:
    """Return a fault where force and deflection run against each other, with the mend that fits.

    Only runs that measure displacements count.

    Parameters
    ----------
    acts_on : what the manifest states now.
    place : the wrench's key in it.
    columns : of the wrench, 3 or 6.
    """
    displaced = np.array([run.measures is StateMeasure.DISPLACEMENT for run in states.runs], dtype=np.bool_)
    chosen = states.select(displaced[states.run] & states.used)
    if not np.any(chosen.wrench) or not chosen.setup.targets or count_distinct(chosen) < 2:
        return []
    sign = work_of_load(chosen, chain)
    present = np.unique(chosen.run)
    negative = int((sign.work[present] < 0.0).sum())
    if 2 * negative <= present.size and sign.explained > FOLLOWS:
        return []
    read = replace(AsRead.all_rows(TriedOn.WORK, chosen, chain), columns=columns, acts_on=acts_on)
    tried = [Scored(explained_by_joints(taken.states, chain), taken) for taken in taken_back(read)]
    orders = [one for one in tried if one.taken.change.kind == WrenchColumns.name]
    others = [one for one in tried if one.taken.change.kind != WrenchColumns.name]
    best = max(others, key=lambda one: one.score)
    against = explained_by_joints(replace(chosen, wrench=-chosen.wrench), chain)
    if orders and len(np.unique(chosen.run)) >= LEAST_POSES and count_loads(chosen) >= LEAST_POSES:
        order = max(orders, key=lambda one: one.score)
        if order.score >= max(ORDER_EXPLAINS, sign.explained + MUCH_MORE, against):
            reason = (
                f"joint-compliance explains {100 * sign.explained:.0f} % of the deflection with the force's columns in "
                f"this order, {100 * order.score:.0f} % in another"
            )
            return [_fault(order, tried, reason, file, place, chain)]
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


def _fault(best: Scored, tried: list[Scored], reason: str, file: str, place: str, chain: Chain) -> Fault:
    mistake, change = best.taken.mistake, best.taken.mistake.as_known(best, tried)
    texts = mistake.texts(change, chain)
    where = f"{place}{texts.place.removeprefix('wrench')}"
    return Fault(mistake.code, file, where, reason, texts.mend, changes=(change,))
