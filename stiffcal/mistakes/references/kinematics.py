"""Kinematics that misses the tracker, with the single change of the manifest that makes it meet.

Like force and deflection against each other (`displacements/work.py`) it makes every later number wrong without looking
wrong (physics, section 0); what fits is named, nothing is changed without a word.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.mistakes.deciding import MUCH_BETTER
from stiffcal.mistakes.inputs.mistake import AsRead, Scored, TriedOn
from stiffcal.mistakes.inputs.taken_back import taken_back
from stiffcal.mistakes.references.corrections import correcting_words, meeting_corrections
from stiffcal.mistakes.references.match import (
    MEETS_M,
    MISSES_M,
    TURNED_RAD,
    KinematicsMatch,
    match_kinematics,
    references_of,
    turned_by,
)
from stiffcal.reduction.registration.still_components import still_words
from stiffcal.wording import length


def miss_words(states: LoadStates, chain: Chain, estimated: bool, stated: Floats, miss_m: float) -> str:
    """Return how far kinematics misses the target in the reference states, with what would make it meet."""
    chosen = references_of(states)
    read = AsRead.all_rows(TriedOn.REFERENCES, chosen, chain, stated)
    meeting = meeting_corrections(read, estimated, MUCH_BETTER * miss_m, list(taken_back(read)))
    return f"{_missed_by(chosen, miss_m)}{correcting_words(meeting, chain)}"


def _missed_by(references: LoadStates, miss_m: float) -> str:
    where = "poses" if references.absolute.all() else "reference states"
    return f"computed and measured target positions differ by {length(miss_m)} in the {where}"


def check_kinematics(
    states: LoadStates, chain: Chain, estimated: bool, stated: Floats, file: str = "campaign.toml"
) -> list[Fault]:
    """Return a fault where kinematics misses the tracker, naming the single change that makes it meet.

    Parameters
    ----------
    estimated : True where the tracker's frame was itself found from these poses.
    stated : (L,) rad, the unit that the manifest states of the logged angles.
    """
    chosen = references_of(states)
    match = match_kinematics(states, chain)
    if len(chosen) == 0 or np.isnan(match.median_m):
        return []
    if match.median_m <= MISSES_M:
        return _check_orientation(chosen, chain, match, estimated, file)
    read = AsRead.all_rows(TriedOn.REFERENCES, chosen, chain, stated)
    ways = list(taken_back(read))
    tried = [Scored(_miss(taken.states, chain, estimated), taken) for taken in ways if not taken.numbers]
    enough = [one for one in tried if one.score <= min(MUCH_BETTER * match.median_m, MEETS_M)]
    # to a nanometre: an estimated frame takes up turned axes, and what these leave differs by rounding alone
    best = min(enough, key=lambda one: round(one.score, 9), default=None)
    least = MUCH_BETTER * min(match.median_m, np.inf if best is None else best.score)
    meeting = meeting_corrections(read, estimated, min(MEETS_M, least), ways)
    if meeting:
        changes: tuple[InputChange, ...] = tuple(change for one in meeting for change in one.changes)
        text = correcting_words(meeting, chain)
        mend = meeting[0].mistakes[0].texts(changes[0], chain).mend
    elif best is not None:
        changes = (best.taken.change,)
        texts = best.taken.mistake.texts(best.taken.change, chain)
        text, mend = f"; with {texts.words} they agree within {length(best.score)}", texts.mend
    else:
        changes = ()
        text, first = still_words(chosen)
        mend = f"{first}check the robot file, the frames of tracker and target, and the joint columns"
    reason = f"{_missed_by(chosen, match.median_m)}{text}"
    return [Fault(FaultCode.KINEMATICS_MISMATCH, file, "kinematics", reason, mend, changes=changes)]


def _miss(states: LoadStates, chain: Chain, estimated: bool) -> float:
    """Return the median distance; a rigid motion apart where the tracker's frame is estimated."""
    predicted, _ = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    measured = states.position[:, 0]
    if estimated and len(measured) > 3:
        left, _, right = np.linalg.svd((predicted - predicted.mean(axis=0)).T @ (measured - measured.mean(axis=0)))
        turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
        measured = (measured - measured.mean(axis=0)) @ turn.T + predicted.mean(axis=0)
    return float(np.median(np.linalg.norm(predicted - measured, axis=1)))


def _check_orientation(
    states: LoadStates, chain: Chain, match: KinematicsMatch, estimated: bool, file: str
) -> list[Fault]:
    """Return a fault where positions meet and orientations do not, unless the target is merely mounted turned."""
    if np.isnan(match.turned_rad) or match.turned_rad <= TURNED_RAD or estimated:
        return []
    _, rotation = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    if len(states) > 1 and _mounting_spread(rotation, states.rotation[:, 0]) <= TURNED_RAD:
        return []
    reason = f"positions agree with the kinematics, orientations differ by {np.degrees(match.turned_rad):.0f}°"
    for taken in taken_back(AsRead.all_rows(TriedOn.ORIENTATIONS, states, chain)):
        if np.median(turned_by(taken.states, chain)) <= TURNED_RAD:
            texts = taken.mistake.texts(taken.change, chain)
            reason = f"{reason}; with {texts.words} they agree"
            return [Fault(taken.mistake.code, file, texts.place, reason, texts.mend, changes=(taken.change,))]
    return [
        Fault(
            FaultCode.KINEMATICS_MISMATCH,
            file,
            "quaternion_wxyz",
            reason,
            "check the quaternion's columns and the tracker's frame",
        )
    ]


def _mounting_spread(computed: Floats, measured: Floats) -> float:
    """Return the spread of the target's orientation on the robot between states, rad."""
    mounting = np.swapaxes(computed, -1, -2) @ measured
    return float(np.max(np.linalg.norm(rotation_vector(mounting @ mounting[0].T), axis=1)))
