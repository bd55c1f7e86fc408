"""Other ways to read a table of displacements, and the one with which these follow the loads.

Angles counted in another unit, direction or from another zero, columns interchanged or with another sign, loads that
act the other way, rows that do not belong together: each is a single mistake of a table, and gives a number of
springs as many readings as before. All of them are compared with the table as it is read, and with each other, by one
F test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.mistakes.displacements.springs import (
    LEAST_POSES,
    count_loads,
    count_poses,
    explained_by_joints,
    is_better,
    left_by_joints,
)
from stiffcal.mistakes.inputs.mistake import AsRead, InputPart, Scored, TriedOn
from stiffcal.mistakes.inputs.taken_back import taken_back
from stiffcal.mistakes.references.match import MISSES_M, TURNED_RAD
from stiffcal.mistakes.some_rows import some_of
from stiffcal.wording import length


@dataclass(frozen=True)
class TablePlaces:
    """Where the manifest says how a table is read."""

    joints: str
    """Key of the joint angles."""
    wrench: str
    """Key of the load."""
    columns: tuple[str, ...] = ()
    """Of the load, 3 or 6; none where a mass is its source."""
    acts_on: str = "robot"
    """What the load acts on as the manifest states it."""
    file: str = "campaign.toml"
    """The manifest."""


def check_other_readings(states: LoadStates, chain: Chain, stated: Floats, places: TablePlaces) -> list[Fault]:
    """Return a fault where the displacements follow the loads only with the table read in another way.

    What the springs leave is compared by an F test, the three components of a pose as one reading each, as the states
    of a pose share what the model lacks. Other angles that move the tool no more than a robot's own inaccuracy does
    are no other reading.

    Parameters
    ----------
    states : load states in use; those with places are let pass, as kinematics shows how their angles are counted.
    stated : (L,) rad, the unit of the logged angles. places : where the manifest says how the table is read.
    """
    is_places = states.has_poses and not states.deflection_given
    if len(states) == 0 or is_places or not states.setup.targets or not np.any(states.wrench):
        return []
    rows = some_of(len(states))
    read = AsRead(TriedOn.DISPLACEMENTS, states, chain, rows, stated, places.columns, places.acts_on)
    if count_poses(read.chosen) < LEAST_POSES:
        return []
    shows_loads = _shows_loads(read.chosen)
    tried = [
        Scored(explained_by_joints(taken.states, taken.chain), taken)
        for taken in taken_back(read)
        if shows_loads or taken.mistake.part is InputPart.ANGLES
    ]
    explained = explained_by_joints(read.chosen, chain)
    ranked = sorted(tried, key=lambda one: -one.score)
    best = next((one for one in ranked if one.taken.mistake.is_distinct(read, one.taken)), None)
    if best is None or not is_better(explained, best.score, best.taken.states, chain, len(tried)):
        return []
    if not _is_another(read.chosen, best.taken.states.joints, chain):
        return []
    return [_fault(best, tried, explained, read, places)]


def _fault(best: Scored, tried: list[Scored], explained: float, read: AsRead, places: TablePlaces) -> Fault:
    mistake = best.taken.mistake
    change = mistake.as_known(best, tried)
    left, measured = left_by_joints(read.chosen, read.chain)
    rms_m = float(np.sqrt(np.mean(left**2)))
    texts = mistake.texts(change, read.chain)
    reason = (
        f"joint springs leave {length(rms_m)} of {length(float(np.sqrt(np.mean(measured**2))))} of the "
        f"deflections, and {length(rms_m * np.sqrt((1.0 - best.score) / max(1.0 - explained, 1e-300)))} with "
        f"{texts.words}"
    )
    place = texts.place
    if mistake.part is InputPart.ANGLES:
        place = f"{places.joints}: {place}" if change.names else f"{places.joints}.{place}"
    elif mistake.part is InputPart.LOADS and place.startswith("wrench"):
        place = f"{places.wrench}{place.removeprefix('wrench')}"
    return Fault(mistake.code, places.file, place, reason, texts.mend, changes=(change,))


def _shows_loads(read: LoadStates) -> bool:
    """Return whether displacements were measured under enough different loads to compare them with these."""
    return read.deflection_given and len(np.unique(read.run)) >= LEAST_POSES and count_loads(read) >= LEAST_POSES


def _is_another(states: LoadStates, joints: Floats, chain: Chain) -> bool:
    """Return whether these joint angles are the states' own, or put the target where no robot's inaccuracy does."""
    if joints is states.joints or len(joints) != len(states) or np.array_equal(joints, states.joints):
        return True
    (place, rotation), (other, turned) = (
        attached_poses(chain, chain.model_angles(angles), states.setup.targets[0]) for angles in (states.joints, joints)
    )
    away = np.linalg.norm(other - place, axis=1)
    angle = np.linalg.norm(rotation_vector(turned @ np.swapaxes(rotation, -1, -2)), axis=1)
    return bool(np.median(away) > MISSES_M or np.median(angle) > TURNED_RAD)
