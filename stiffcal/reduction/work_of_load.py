"""Force and deflection against each other, with the single change of the manifest that fits.

The fault makes every later number wrong without looking wrong. Where the data contradict the manifest, the single
change of it that fits is looked for and named (physics, section 0); nothing is changed silently.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import Fault
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.fault_changes import FORCES_ALONE, ChangeKind, InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.reduction.change_texts import code_of, texts_of
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
        references = _references(states)
        force, moment = force - force[references], moment - moment[references]
        turn = states.rotation[:, 0] @ states.rotation[references, 0].swapaxes(1, 2)
        measured = np.isfinite(turn).all(axis=(1, 2))
        measured &= ~np.isin(states.run, states.run[~measured])  # of a run all states or none
        rotation = np.zeros_like(force)
        rotation[measured] = rotation_vector(turn[measured])
        translation = motion_of(states, chain).since(references)
    return force, moment, np.nan_to_num(translation + np.cross(rotation, point - target)), rotation


def _references(states: LoadStates) -> Integers:
    """Return (n,) of each state its run's first reference, or first state where it has none."""
    references = np.zeros(len(states), dtype=np.int64)
    first = np.argsort(~states.reference, kind="stable")  # references before others, each in order
    _, place, number = np.unique(states.run[first], return_index=True, return_inverse=True)
    references[first] = first[place][number.ravel()]
    return references


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

    Only runs that measure displacements count.

    Parameters
    ----------
    acts_on : what the manifest states now.
    place : the wrench's key in it.
    columns : of the wrench, 3 or 6.
    """
    displaced = np.array([run.measures is StateMeasure.DISPLACEMENT for run in states.runs], dtype=np.bool_)
    chosen = states.select(displaced[states.run] & states.used)
    if not np.any(chosen.wrench) or not chosen.setup.targets or _count_distinct(chosen) < 2:
        return []
    sign = work_of_load(chosen, chain)
    present = np.unique(chosen.run)
    negative = int((sign.work[present] < 0.0).sum())
    if 2 * negative <= present.size and sign.explained > FOLLOWS:
        return []
    swapped = _swapped_columns(chosen, chain, sign.explained, columns)
    if swapped:
        reason, change = swapped
        mend = texts_of(change, chain).mend
        return [Fault(code_of(change), file, f"{place}.columns", reason, mend, changes=(change,))]
    turns = {axis: np.diag([1.0 if k == axis else -1.0 for k in range(3)]) for axis in range(3)}
    against = explained_by_joints(chosen, chain, sign=-1.0)
    by_axis = {axis: explained_by_joints(chosen, chain, flip) for axis, flip in turns.items()}
    axis = max(by_axis, key=lambda number: by_axis[number])
    best = max(against, by_axis[axis])
    if 2 * negative <= present.size and sign.explained > FOLLOWS_NOT:
        return []
    if best > FOLLOWS and best > sign.explained + 0.25:
        if against == best:
            opposite = "robot" if acts_on == "environment" else "environment"
            change = InputChange(ChangeKind.ACTS_ON, value=opposite)
        else:
            change = InputChange(ChangeKind.SENSOR_AXES, ("xyz"[axis],), (np.pi,))
        reason = f"force and deflection have opposite directions (negative work in {negative} of {present.size} runs)"
        return [Fault(code_of(change), file, place, reason, texts_of(change, chain).mend, changes=(change,))]
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


def count_loads(states: LoadStates) -> int:
    """Return the number of directions of the load on the robot, poses that are alike taken as one."""
    size = np.linalg.norm(states.wrench[:, :3], axis=1)
    loaded = size > 0.1 * size.max()
    direction = states.wrench[loaded, :3] / size[loaded, None]
    return len(np.unique(np.round(np.concatenate([states.joints[loaded], direction], axis=1), 1), axis=0))


def column_orders(columns: tuple[str, ...]) -> Iterator[tuple[tuple[int, ...], tuple[str, ...]]]:
    """Yield other orders of a wrench's six components, with the force's columns and the moment's in that order.

    Parameters
    ----------
    columns : of the wrench, 3 or 6; of another number there is no other order.
    """
    kept = (0, 1, 2)
    for order in permutations(kept) if len(columns) in (3, 6) else ():
        for moments in (kept, order) if order != kept else ():
            components = (*order, *(3 + k for k in moments))
            if len(columns) == 6:
                yield components, tuple(columns[k] for k in components)
            elif moments == kept:
                yield components, tuple(columns[k] for k in order)


def surely_ordered(change: InputChange, share: float, tried: list[tuple[float, InputChange]]) -> InputChange:
    """Return an order of the wrench's columns, marked where the moments carry too little information for theirs.

    Parameters
    ----------
    change : the order. share : that springs explain with it. tried : all orders, and what springs explain with each.
    """
    for other_share, other in tried:
        same = other.kind is change.kind and other.names[:3] == change.names[:3] and other != change
        if same and 1.0 - share >= CLEARLY_LESS * (1.0 - other_share):
            return replace(change, value=FORCES_ALONE)
    return change


def _swapped_columns(
    states: LoadStates, chain: Chain, explained: float, columns: tuple[str, ...]
) -> tuple[str, InputChange] | None:
    """Return reason and change where only another order of the force's columns explains the deflection."""
    if len(np.unique(states.run)) < LEAST_POSES or count_loads(states) < LEAST_POSES:
        return None
    tried = [
        (
            explained_by_joints(replace(states, wrench=states.wrench[:, components]), chain),
            InputChange(ChangeKind.WRENCH_COLUMNS, names),
        )
        for components, names in column_orders(columns)
    ]
    if not tried:
        return None
    best, change = max(tried, key=lambda entry: entry[0])
    reversed_share = explained_by_joints(states, chain, sign=-1.0)
    if best < max(ORDER_EXPLAINS, explained + 0.25, reversed_share):
        return None
    reason = (
        f"joint springs explain {100 * explained:.0f} % of the deflection with the force's columns in this order, "
        f"{100 * best:.0f} % in another"
    )
    return reason, surely_ordered(change, best, tried)
