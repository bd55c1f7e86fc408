"""Force and deflection against each other, with the single change of the manifest that fits.

The fault makes every later number wrong without looking wrong. Where the data contradict the manifest, the single
change of it that fits is looked for and named (physics, section 0); nothing is changed silently.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.reduction.motion import mean_measured, motion_of

# A load that follows the declared axes leaves less than half of the deflection to other effects.
FOLLOWS, FOLLOWS_NOT = 0.8, 0.5
# Another order of the force's columns has to explain nearly all, and much more; of few poses any order explains much.
ORDER_EXPLAINS, LEAST_POSES = 0.9, 3
CLEARLY_LESS = 0.9  # of what the other order of the moments leaves
# The size of the test of another way to read a table, all that are tried counted.
BY_CHANCE = 1e-4
# Of the sum of squares: a millionth of the displacement, below what any instrument reads and above rounding.
NOTHING_LEFT = 1e-12


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
        reason, mend, change = swapped
        return [Fault(FaultCode.WRENCH_MISMATCH, file, f"{place}.columns", reason, mend, changes=(change,))]
    turns = {axis: np.diag([1.0 if k == axis else -1.0 for k in range(3)]) for axis in range(3)}
    against = explained_by_joints(chosen, chain, sign=-1.0)
    by_axis = {axis: explained_by_joints(chosen, chain, flip) for axis, flip in turns.items()}
    axis = max(by_axis, key=lambda number: by_axis[number])
    best = max(against, by_axis[axis])
    mirrored = _mirrored_axes(chosen, chain, sign.explained, best, columns)
    if mirrored is not None:
        return [replace(mirrored, file=file)]
    if 2 * negative <= present.size and sign.explained > FOLLOWS_NOT:
        return []
    if best > FOLLOWS and best > sign.explained + 0.25:
        if against == best:
            opposite = "robot" if acts_on == "environment" else "environment"
            change = InputChange(ChangeKind.ACTS_ON, value=opposite)
            mend = f"acts_on is inverted: write {toml_text.pair('acts_on', opposite)}"
        else:
            change = InputChange(ChangeKind.SENSOR_AXES, ("xyz"[axis],), (np.pi,))
            mend = f"the sensor is upside down, half a turn about {'xyz'[axis]} of its axes: correct its frame"
        reason = f"force and deflection have opposite directions (negative work in {negative} of {present.size} runs)"
        return [Fault(FaultCode.WRENCH_MISMATCH, file, place, reason, mend, changes=(change,))]
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


def _mirrored_axes(
    states: LoadStates, chain: Chain, explained: float, turned: float, columns: tuple[str, ...]
) -> Fault | None:
    """Return the fault of one force with another sign, or of a displacement's axes in another order or sign.

    No turn of a sensor makes the first, and no frame the second: all of a table's displacements follow the loads then.
    What springs leave is compared by an F test, the three components of a pose as one reading each: of few poses any
    order of axes explains much.

    Parameters
    ----------
    explained : share that springs explain as declared. turned : with the load turned. columns : of the wrench.
    """
    if not states.deflection_given or len(np.unique(states.run)) < LEAST_POSES or _count_loads(states) < LEAST_POSES:
        return None
    tried: list[tuple[float, InputChange]] = []
    for k, name in enumerate(columns[:3]):
        wrench = states.wrench * np.where(np.arange(6) == k, -1.0, 1.0)
        share = explained_by_joints(replace(states, wrench=wrench), chain)
        tried.append((share, InputChange(ChangeKind.WRENCH_SIGN, (name,))))
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            # nothing is changed, or all of the load acts the other way
            if order == (0, 1, 2) and abs(sum(signs)) == 3.0:
                continue
            deflection = states.deflection.copy()
            deflection[:, :, :3] = deflection[:, :, order] * np.array(signs)
            axes = tuple(f"{'-' if sign < 0.0 else ''}{'XYZ'[k]}" for k, sign in zip(order, signs, strict=True))
            share = explained_by_joints(replace(states, deflection=deflection), chain)
            tried.append((share, InputChange(ChangeKind.DISPLACEMENT_AXES, axes)))
    share, change = max(tried, key=lambda entry: entry[0])
    if share <= max(FOLLOWS, explained, turned) or chance_of(explained, share, states, chain) * len(tried) > BY_CHANCE:
        return None
    if change.kind is ChangeKind.WRENCH_SIGN:
        place, words, mend = f"column {change.names[0]}", "the other sign", "correct its sign in the log"
    else:
        place, words = "displacements", f"their axes as ({', '.join(change.names)})"
        mend = "correct the order and the signs of their columns, or their axes"
    reason = f"joint springs explain {100 * explained:.0f} % of the deflection, and {100 * share:.0f} % with {words}"
    return Fault(FaultCode.WRENCH_MISMATCH, "", place, reason, mend, changes=(change,))


def chance_of(explained: float, share: float, states: LoadStates, chain: Chain) -> float:
    """Return the probability by which springs explain so much more with another reading of a table by chance."""
    from scipy.special import fdtrc

    poses = len(np.unique(np.round(np.degrees(states.joints), 2), axis=0))
    free = 3 * poses - chain.n_joints
    if free < 2:
        return 1.0
    return float(fdtrc(free, free - 1, max(1.0 - explained, NOTHING_LEFT) / max(1.0 - share, NOTHING_LEFT)))


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
) -> tuple[str, str, InputChange] | None:
    """Return reason, mend and change where only another order of the force's columns explains the deflection."""
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
    right_columns = (*names, *(of_moments if is_sure else ()))
    if not is_sure:  # the moments carry too little information
        mend += ", and check whether the moments are interchanged too"
    mend = f"columns are interchanged, here or in the log: {mend}"
    return reason, mend, InputChange(ChangeKind.WRENCH_COLUMNS, right_columns)
