"""Kinematics that misses the tracker, with the single change of the manifest that makes it meet.

Like force and deflection against each other (`work_of_load`) it makes every later number wrong without looking wrong
(physics, section 0); what fits is named, nothing is changed without a word.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import inverse_transform
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.quaternions import quaternion_from_rotation, rotation_from_quaternion
from stiffcal.reduction.angle_conventions import counted_otherwise, logged_names
from stiffcal.reduction.change_texts import code_of, texts_of
from stiffcal.reduction.kinematics_corrections import MUCH_BETTER, correcting_words, meeting_corrections
from stiffcal.reduction.still_components import still_words

# Physics, section 0: kinematics meets the measured target within some 20 mm in the reference states.
MEETS_M = 0.02
# Beyond this no robot's own inaccuracy explains it; between the two a warning is enough.
MISSES_M = 0.05
TURNED_RAD = 0.1


@dataclass(frozen=True)
class KinematicsMatch:
    """How well kinematics meets the tracker in the reference states."""

    median_m: float
    """Median distance between the computed and the measured target; NaN where positions are not measured."""
    worst_m: float
    """The largest such distance."""
    turned_rad: float
    """Median angle between the computed and the measured orientation, NaN where not measured."""


def match_kinematics(states: LoadStates, chain: Chain) -> KinematicsMatch:
    """Compare kinematics with the measured target in the reference states."""
    chosen = _references(states)
    if len(chosen) == 0:
        return KinematicsMatch(np.nan, np.nan, np.nan)
    predicted, rotation = attached_poses(chain, chain.model_angles(chosen.joints), chosen.setup.targets[0])
    away = np.linalg.norm(predicted - chosen.position[:, 0], axis=1)
    turn = np.linalg.norm(rotation_vector(chosen.rotation[:, 0] @ np.swapaxes(rotation, -1, -2)), axis=1)
    median_angle = float(np.median(turn)) if np.isfinite(turn).all() else np.nan
    return KinematicsMatch(float(np.median(away)), float(away.max()), median_angle)


def miss_words(states: LoadStates, chain: Chain, estimated: bool, miss_m: float) -> str:
    """Return how far kinematics misses the target in the reference states, with what would make it meet."""
    chosen = _references(states)
    meeting = meeting_corrections(chosen, chain, estimated, MUCH_BETTER * miss_m)
    return f"{_missed_by(chosen, miss_m)}{correcting_words(meeting, chain)}"


def _missed_by(references: LoadStates, miss_m: float) -> str:
    where = "poses" if references.absolute.all() else "reference states"
    return f"computed and measured target positions differ by {1e3 * miss_m:.0f} mm in the {where}"


def _references(states: LoadStates) -> LoadStates:
    """Return the states that frames are found from: used, unloaded, and with the first target measured."""
    measured = (
        np.isfinite(states.position[:, :1]).all(axis=(1, 2)) if states.setup.targets else np.zeros(len(states), bool)
    )
    return states.select(states.reference & states.used & measured)


def check_kinematics(
    states: LoadStates, chain: Chain, estimated: bool, stated: Floats, file: str = "campaign.toml"
) -> list[Fault]:
    """Return a fault where kinematics misses the tracker, naming the single change that makes it meet.

    Parameters
    ----------
    estimated : True where the tracker's frame was itself found from these poses.
    stated : (L,) rad, the unit that the manifest states of the logged angles.
    """
    chosen = _references(states)
    match = match_kinematics(states, chain)
    if len(chosen) == 0 or np.isnan(match.median_m):
        return []
    if match.median_m <= MISSES_M:
        return _check_orientation(chosen, chain, match, estimated, file)
    best, named = np.inf, None
    for variant in _variants(chosen, chain, stated):
        predicted, _ = attached_poses(chain, chain.model_angles(variant.joints), chosen.setup.targets[0])
        left = _miss(predicted, variant.position, estimated)
        if left < best:
            best, named = left, variant
    if best > MUCH_BETTER * match.median_m or best > MEETS_M:
        best, named = np.inf, None
    least = MUCH_BETTER * min(match.median_m, best)
    meeting = meeting_corrections(chosen, chain, estimated, min(MEETS_M, least))
    changes = tuple(change for one in meeting for change in one.changes)
    if meeting:
        text, mend = correcting_words(meeting, chain), texts_of(changes[0], chain).mend
    elif named is not None:
        texts, changes = texts_of(named.change, chain), (named.change,)
        text, mend = f"; with {texts.words} they agree within {1e3 * best:.1f} mm", texts.mend
    else:
        text, first = still_words(chosen)
        mend = f"{first}check the robot file, the frames of tracker and target, and the joint columns"
    reason = f"{_missed_by(chosen, match.median_m)}{text}"
    return [Fault(FaultCode.KINEMATICS_MISMATCH, file, "kinematics", reason, mend, changes=changes)]


def _miss(predicted: Floats, measured: Floats, estimated: bool) -> float:
    """Return the median distance; a rigid motion apart where the tracker's frame is estimated."""
    if estimated and len(measured) > 3:
        left, _, right = np.linalg.svd((predicted - predicted.mean(axis=0)).T @ (measured - measured.mean(axis=0)))
        turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
        measured = (measured - measured.mean(axis=0)) @ turn.T + predicted.mean(axis=0)
    return float(np.median(np.linalg.norm(predicted - measured, axis=1)))


@dataclass(frozen=True)
class _Variant:
    """Joints and places as they would be with one change."""

    joints: Floats
    """(n, L)."""
    position: Floats
    """(n, 3), base axes."""
    change: InputChange
    """What is changed."""


def _variants(states: LoadStates, chain: Chain, stated: Floats) -> Iterator[_Variant]:
    """Yield what may be wrong, with joints and positions as they would be."""
    joints, position = states.joints, states.position[:, 0]
    names = logged_names(joints, chain)
    for counted in counted_otherwise(joints, chain, stated):
        yield _Variant(counted.joints, position, counted.change)
    for k in np.flatnonzero(chain.prismatic):
        for unit, factor in (("mm", 1e-3), ("m", 1e3)):
            scaled = joints.copy()
            scaled[:, k] *= factor
            change = InputChange(ChangeKind.JOINT_UNIT, (names[k],), value=unit)
            yield _Variant(scaled, position, change)
    base_from_tracker = states.base_from_tracker
    own = _moved(inverse_transform(base_from_tracker), position)
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            if order == (0, 1, 2) and signs == (1.0, 1.0, 1.0):
                continue
            axes = tuple(f"{'-' if s < 0 else ''}{'XYZ'[k]}" for k, s in zip(order, signs, strict=True))
            measured = _moved(base_from_tracker, own[:, order] * np.array(signs))
            yield _Variant(joints, measured, InputChange(ChangeKind.TRACKER_AXES, axes))
    for factor, unit in ((1e-3, "mm"), (1e3, "m")):
        measured = _moved(base_from_tracker, own * factor)
        yield _Variant(joints, measured, InputChange(ChangeKind.LENGTH_UNIT, value=unit))
    inverse = _moved(inverse_transform(base_from_tracker), own)
    yield _Variant(joints, inverse, InputChange(ChangeKind.INVERSE_FRAME))


def _moved(motion: Floats, places: Floats) -> Floats:
    """Return places (n, 3) as each one's motion (n, 4, 4) takes them."""
    return np.asarray(np.einsum("nij,nj->ni", motion[:, :3, :3], places) + motion[:, :3, 3])


def _check_orientation(
    states: LoadStates, chain: Chain, match: KinematicsMatch, estimated: bool, file: str
) -> list[Fault]:
    """Return a fault where positions meet and orientations do not, unless the target is merely mounted turned."""
    if np.isnan(match.turned_rad) or match.turned_rad <= TURNED_RAD or estimated:
        return []
    _, rotation = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    tracker_axes = states.base_from_tracker[:, :3, :3]
    measured = np.swapaxes(tracker_axes, -1, -2) @ states.rotation[:, 0]
    if len(states) > 1 and _mounting_spread(rotation, tracker_axes @ measured) <= TURNED_RAD:
        return []
    quaternion = quaternion_from_rotation(measured)
    orders = ((ChangeKind.QUATERNION_ORDER, [3, 0, 1, 2], 1.0), (ChangeKind.QUATERNION_INVERSE, [0, 1, 2, 3], -1.0))
    reason = f"positions agree with the kinematics, orientations differ by {np.degrees(match.turned_rad):.0f}°"
    for kind, order, sign in orders:
        values = quaternion[:, order] * np.array([1.0, sign, sign, sign])
        deviation = rotation_vector(tracker_axes @ rotation_from_quaternion(values) @ np.swapaxes(rotation, -1, -2))
        if np.median(np.linalg.norm(deviation, axis=1)) <= TURNED_RAD:
            change = InputChange(kind)
            texts = texts_of(change, chain)
            reason = f"{reason}; with {texts.words} they agree"
            return [Fault(code_of(change), file, texts.place, reason, texts.mend, changes=(change,))]
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
