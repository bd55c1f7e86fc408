"""What load states cannot be: force and deflection against each other, kinematics that misses the tracker.

These are the faults that make every later number wrong without looking wrong. Where the data contradict the manifest,
the single change of it that fits is looked for and named (physics, section 0); nothing is changed silently.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.rotations import inverse_transform
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.quaternions import quaternion_from_rotation, rotation_from_quaternion
from stiffcal.reduction.angle_conventions import counted_otherwise
from stiffcal.reduction.kinematics_corrections import MUCH_BETTER, correcting_words
from stiffcal.reduction.motion import mean_measured, motion_of
from stiffcal.reduction.still_components import still_words

# Physics, section 0: kinematics meets the measured target within some 20 mm in the reference states.
MEETS_M = 0.02
# Beyond this no robot's own inaccuracy explains it; between the two a warning is enough.
MISSES_M = 0.05
TURNED_RAD = 0.1
# A load that follows the declared axes leaves less than half of the deflection to other effects.
FOLLOWS, FOLLOWS_NOT = 0.8, 0.5
# Another order of the force's columns has to explain nearly all, and much more; of few poses any order explains much.
ORDER_EXPLAINS, LEAST_POSES = 0.9, 3
CLEARLY_LESS = 0.9  # of what the other order of the moments leaves


@dataclass(frozen=True)
class WorkSign:
    """Work of the load on the robot, per run, J; share of the deflection that positive joint springs explain."""

    work: Floats
    explained: float


def work_of_load(states: LoadStates, chain: Chain) -> WorkSign:
    """Return Σ wrench · displacement about the load's point in each run (differences to the run's reference), J."""
    return WorkSign(work_of_runs(states, chain), explained_by_joints(states, chain))


def work_of_runs(states: LoadStates, chain: Chain) -> Floats:
    """Return (R,) the same work alone, J."""
    force, moment, translation, rotation = _loads_and_motions(states, chain)
    work = np.sum(force * translation, axis=1) + np.sum(moment * rotation, axis=1)
    return np.array([work[members].sum() for members in states.members()])


def _loads_and_motions(states: LoadStates, chain: Chain) -> tuple[Floats, Floats, Floats, Floats]:
    """Return force, moment, displacement of the load's point and turn, base axes, relative to the reference: (n, 3)."""
    angles = chain.model_angles(states.joints)
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    point, _ = attached_poses(chain, angles, states.setup.wrench_point)
    target, _ = attached_poses(chain, angles, states.setup.targets[0])
    force = np.einsum("nij,nj->ni", axes, states.wrench[:, :3])
    moment = np.einsum("nij,nj->ni", axes, states.wrench[:, 3:])
    if states.deflection_given:
        translation, rotation = states.deflection[:, 0, :3].copy(), np.nan_to_num(states.deflection[:, 0, 3:])
    else:
        rotation = np.zeros_like(force)
        references = np.zeros(len(states), dtype=np.int64)
        for members in members_of(states.run):
            first = members[states.reference[members]]
            reference = int(first[0]) if first.size else int(members[0])
            references[members] = reference
            force[members] -= force[reference].copy()
            moment[members] -= moment[reference].copy()
            turn = states.rotation[members, 0] @ states.rotation[reference, 0].T
            if np.isfinite(turn).all():
                rotation[members] = rotation_vector(turn)
        translation = motion_of(states, chain).since(references)
    return force, moment, np.nan_to_num(translation + np.cross(rotation, point - target)), rotation


def explained_by_joints(states: LoadStates, chain: Chain, flip: Floats | None = None, sign: float = 1.0) -> float:
    """Return the share of displacement that non-negative joint compliances explain, sensor axes turned by `flip`."""
    left, measured = left_by_joints(states, chain, flip, sign)
    total = float(measured @ measured)
    return 1.0 - float(left @ left) / total if total > 0.0 else 1.0


def left_by_joints(
    states: LoadStates, chain: Chain, flip: Floats | None = None, sign: float = 1.0
) -> tuple[Floats, Floats]:
    """Return (k,) what non-negative joint compliances leave of the k measured components, and these themselves, m.

    Of places what counts is the distance from their mean in each run.
    """
    angles = chain.model_angles(states.joints)
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    joint_axes = sign * (axes if flip is None else axes @ flip)
    wrench = np.concatenate(
        [
            np.einsum("nij,nj->ni", joint_axes, states.wrench[:, :3]),
            np.einsum("nij,nj->ni", joint_axes, states.wrench[:, 3:]),
        ],
        axis=1,
    )
    # springs sit at the drives
    drives = jacobians(chain, angles, states.setup.wrench_point) @ chain.drive_axes
    torque = np.einsum("nij,ni->nj", drives, wrench)
    motion = motion_of(states, chain)
    columns = motion.columns(states, chain) @ chain.drive_axes * torque[:, None, :]
    measured = motion.measured
    if not states.deflection_given:
        for members in members_of(states.run):
            columns[members] -= columns[members].mean(axis=0)
            measured[members] -= mean_measured(measured[members])
    rows = np.isfinite(measured).ravel()
    design, target = columns.reshape(-1, columns.shape[2])[rows], measured.ravel()[rows]
    scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    gram, right = np.linalg.qr(design / scale)
    zero = np.zeros(right.shape[1])
    value, _ = least_squares_within(right, gram.T @ target, zero, zero + np.inf)
    return target - gram @ (right @ value), target


def check_work(
    states: LoadStates,
    chain: Chain,
    file: str = "campaign.toml",
    acts_on: str = "robot",
    place: str = "wrench",
    columns: tuple[str, ...] = (),
) -> list[Fault]:
    """Return a fault where force and deflection run against each other, with the mend that fits.

    Only runs of experiment "load" count.

    Parameters
    ----------
    acts_on : what the manifest states now.
    place : the wrench's key in it.
    columns : of the wrench, 3 or 6.
    """
    loads = np.array([states.runs[k].experiment == "load" for k in states.run], dtype=np.bool_) & states.used
    chosen = states.select(loads)
    if not np.any(chosen.wrench) or not chosen.setup.targets or _count_distinct(chosen) < 2:
        return []
    sign = work_of_load(chosen, chain)
    present = np.unique(chosen.run)
    negative = int((sign.work[present] < 0.0).sum())
    if 2 * negative <= present.size and sign.explained > FOLLOWS:
        return []
    swapped = _swapped_column_fault(chosen, chain, sign.explained, columns)
    if swapped:
        return [Fault(FaultCode.WRENCH_MISMATCH, file, f"{place}.columns", *swapped)]
    if 2 * negative <= present.size and sign.explained > FOLLOWS_NOT:
        return []
    turns = {axis: np.diag([1.0 if k == axis else -1.0 for k in range(3)]) for axis in range(3)}
    against = explained_by_joints(chosen, chain, sign=-1.0)
    by_axis = {axis: explained_by_joints(chosen, chain, flip) for axis, flip in turns.items()}
    axis = max(by_axis, key=lambda number: by_axis[number])
    best = max(against, by_axis[axis])
    if best > FOLLOWS and best > sign.explained + 0.25:
        if against == best:
            opposite = "robot" if acts_on == "environment" else "environment"
            mend = f"acts_on is inverted: write {toml_text.pair('acts_on', opposite)}"
        else:
            mend = f"the sensor is upside down, half a turn about {'xyz'[axis]} of its axes: correct its frame"
        reason = f"force and deflection have opposite directions (negative work in {negative} of {present.size} runs)"
        return [Fault(FaultCode.WRENCH_MISMATCH, file, place, reason, mend)]
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


def _count_distinct(states: LoadStates) -> int:
    """Return the number of different states: one row written ten times is one reading."""
    measured = [values.reshape(len(states), -1) for values in (states.position, states.deflection)]
    rows = np.nan_to_num(np.concatenate([states.joints, states.wrench, *measured], axis=1))
    return len(np.unique(rows, axis=0))


def _count_loads(states: LoadStates) -> int:
    """Return the number of directions of the load on the robot, poses that are alike taken as one."""
    size = np.linalg.norm(states.wrench[:, :3], axis=1)
    loaded = size > 0.1 * size.max()
    direction = states.wrench[loaded, :3] / size[loaded, None]
    return len(np.unique(np.round(np.concatenate([states.joints[loaded], direction], axis=1), 1), axis=0))


def _swapped_column_fault(
    states: LoadStates, chain: Chain, explained: float, columns: tuple[str, ...]
) -> tuple[str, str] | None:
    """Return reason and mend where another order of the force's columns explains the deflection, and this does not."""
    if len(columns) not in (3, 6) or len(np.unique(states.run)) < LEAST_POSES or _count_loads(states) < LEAST_POSES:
        return None

    def share_with(order: tuple[int, ...], moments: tuple[int, ...]) -> float:
        wrench = states.wrench[:, [*order, *(3 + k for k in moments)]]
        return explained_by_joints(replace(states, wrench=wrench), chain)

    kept = (0, 1, 2)
    shares = {(order, moments): share_with(order, moments) for order in permutations(kept) for moments in {kept, order}}
    (right, moments), best = max(shares.items(), key=lambda entry: entry[1])
    reversed_share = explained_by_joints(states, chain, sign=-1.0)
    if right == kept or best < max(ORDER_EXPLAINS, explained + 0.25, reversed_share):
        return None
    other_share = shares[right, right if moments == kept else kept]
    reason = (
        f"joint springs explain {100 * explained:.0f} % of the deflection with the force's columns in this order, "
        f"{100 * best:.0f} % in another"
    )
    names, of_moments = [columns[k] for k in right], list(columns[3:])
    is_sure = len(columns) == 3 or 1.0 - best < CLEARLY_LESS * (1.0 - other_share)
    if len(columns) > 3 and is_sure:
        of_moments = [columns[3 + k] for k in moments]
    mend = f"write {toml_text.pair('columns', names + of_moments)}"
    if not is_sure:  # the moments carry too little information
        mend += ", and check whether the moments are interchanged too"
    return reason, f"columns are interchanged, here or in the log: {mend}"


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
    words, _ = correcting_words(chosen, chain, estimated, MUCH_BETTER * miss_m)
    return f"{_missed_by(chosen, miss_m)}{words}"


def _missed_by(references: LoadStates, miss_m: float) -> str:
    where = "poses" if references.absolute.all() else "reference states"
    return f"computed and measured target positions differ by {1e3 * miss_m:.0f} mm in the {where}"


def _references(states: LoadStates) -> LoadStates:
    """Return the states that frames are found from: used, unloaded, and with the first target measured."""
    measured = (
        np.isfinite(states.position[:, :1]).all(axis=(1, 2)) if states.setup.targets else np.zeros(len(states), bool)
    )
    return states.select(states.reference & states.used & measured)


def check_kinematics(states: LoadStates, chain: Chain, estimated: bool, file: str = "campaign.toml") -> list[Fault]:
    """Return a fault where kinematics misses the tracker, naming the single change that makes it meet.

    Parameters
    ----------
    estimated : True where the tracker's frame was itself found from these poses.
    """
    chosen = _references(states)
    match = match_kinematics(states, chain)
    if len(chosen) == 0 or np.isnan(match.median_m):
        return []
    if match.median_m <= MISSES_M:
        return _check_orientation(chosen, chain, match, estimated, file)
    misses: list[tuple[float, str, str]] = []
    for text, mend, joints, position in _variants(chosen, chain):
        predicted, _ = attached_poses(chain, chain.model_angles(joints), chosen.setup.targets[0])
        misses.append((_miss(predicted, position, estimated), text, mend))
    best = min(misses, key=lambda entry: entry[0])
    if best[0] > MUCH_BETTER * match.median_m or best[0] > MEETS_M:
        best = (np.inf, "", "")
    reason = _missed_by(chosen, match.median_m)
    least = MUCH_BETTER * min(match.median_m, best[0])
    text, mend = correcting_words(chosen, chain, estimated, min(MEETS_M, least))
    if not text and best[1]:
        text, mend = f"; with {best[1]} they agree within {1e3 * best[0]:.1f} mm", best[2]
    if not text:
        text, first = still_words(chosen)
        mend = f"{first}check the robot file, the frames of tracker and target, and the joint columns"
    return [Fault(FaultCode.KINEMATICS_MISMATCH, file, "kinematics", f"{reason}{text}", mend)]


def _miss(predicted: Floats, measured: Floats, estimated: bool) -> float:
    """Return the median distance; a rigid motion apart where the tracker's frame is estimated."""
    if estimated and len(measured) > 3:
        left, _, right = np.linalg.svd((predicted - predicted.mean(axis=0)).T @ (measured - measured.mean(axis=0)))
        turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
        measured = (measured - measured.mean(axis=0)) @ turn.T + predicted.mean(axis=0)
    return float(np.median(np.linalg.norm(predicted - measured, axis=1)))


def _variants(states: LoadStates, chain: Chain) -> Iterator[tuple[str, str, Floats, Floats]]:
    """Yield what may be wrong, in words and with its mend, and joints (n, L) and positions (n, 3) as they would be."""
    joints, position = states.joints, states.position[:, 0]
    names = chain.joint_names if len(chain.joint_names) == joints.shape[1] else tuple(map(str, range(joints.shape[1])))
    for counted in counted_otherwise(joints, chain):
        yield counted.words, counted.mend, counted.joints, position
    for k in np.flatnonzero(chain.prismatic):
        for unit, factor in (("mm", 1e-3), ("m", 1e3)):
            scaled = joints.copy()
            scaled[:, k] *= factor
            yield f"joint {names[k]} in {unit}", f"correct the unit of {names[k]}", scaled, position
    base_from_tracker = states.base_from_tracker
    own = _moved(inverse_transform(base_from_tracker), position)
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            if order == (0, 1, 2) and signs == (1.0, 1.0, 1.0):
                continue
            axes = ", ".join(f"{'-' if s < 0 else ''}{'XYZ'[k]}" for k, s in zip(order, signs, strict=True))
            measured = _moved(base_from_tracker, own[:, order] * np.array(signs))
            yield (
                f"the tracker's axes as ({axes})",
                "correct the order of position's columns, or the frame",
                joints,
                measured,
            )
    for factor, unit in ((1e-3, "mm"), (1e3, "m")):
        measured = _moved(base_from_tracker, own * factor)
        yield f"positions in {unit}", f"write {toml_text.pair('units', {'position': unit})}", joints, measured
    yield (
        "the inverse of the tracker frame",
        "frames.tracker is the pose of the tracker in the base frame, not of the base in the tracker frame",
        joints,
        _moved(inverse_transform(base_from_tracker), own),
    )


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
    orders = (
        ("x, y, z, w", quaternion[:, [3, 0, 1, 2]], "write the quaternion's columns with w first"),
        ("inverted", quaternion * np.array([1.0, -1.0, -1.0, -1.0]), "invert the orientation"),
    )
    reason = f"positions agree with the kinematics, orientations differ by {np.degrees(match.turned_rad):.0f}°"
    for text, values, mend in orders:
        deviation = rotation_vector(tracker_axes @ rotation_from_quaternion(values) @ np.swapaxes(rotation, -1, -2))
        if np.median(np.linalg.norm(deviation, axis=1)) <= TURNED_RAD:
            return [
                Fault(
                    FaultCode.KINEMATICS_MISMATCH,
                    file,
                    "quaternion_wxyz",
                    f"{reason}; with the quaternion {text} they agree",
                    mend,
                )
            ]
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
