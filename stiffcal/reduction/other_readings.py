"""Other ways to read a table of displacements, and the one with which these follow the loads.

Angles counted in another unit, direction or from another zero, columns interchanged or with another sign, loads that
act the other way, rows that do not belong together: each is a single mistake of a table, and gives a number of
springs as many readings as before. All of them are compared with the table as it is read, and with each other, by one
F test.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import Fault
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.reduction.angle_conventions import counted_otherwise
from stiffcal.reduction.change_texts import code_of, texts_of
from stiffcal.reduction.consistency import MISSES_M, TURNED_RAD
from stiffcal.reduction.joint_zeros import other_zeros
from stiffcal.reduction.work_of_load import (
    BY_CHANCE,
    FOLLOWS,
    LEAST_POSES,
    chance_of,
    column_orders,
    count_loads,
    explained_by_joints,
    left_by_joints,
    surely_ordered,
)

# Of more states so many are compared: a few hundred poses determine six springs.
MOST_STATES = 300
SAME_POSE_RAD = np.radians(0.01)
# By so many rows at most the columns of a table are taken to be moved against each other.
MOST_ROWS_MOVED = 3


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


@dataclass(frozen=True)
class _Reading:
    states: LoadStates
    """As they are if they are read so."""
    change: InputChange
    holds: bool = True
    """False where rows of a pose alone follow their loads better."""


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
    some = _some(len(states))
    read = states.select(some)
    if _count_poses(read) < LEAST_POSES:
        return []
    tried = [
        (explained_by_joints(reading.states, chain), reading)
        for reading in (*_readings(read, chain, stated, places), *_other_rows(states, some, chain))
    ]
    share, best = max((entry for entry in tried if entry[1].holds), key=lambda entry: entry[0])
    explained = explained_by_joints(read, chain)
    if not _is_better(explained, share, best.states, chain, len(tried)):
        return []
    if not _is_another(read, best.states.joints, chain):
        return []
    change = surely_ordered(best.change, share, [(other, reading.change) for other, reading in tried])
    return [_fault(change, explained, share, read, chain, places)]


def _fault(
    change: InputChange, explained: float, share: float, read: LoadStates, chain: Chain, places: TablePlaces
) -> Fault:
    left, measured = left_by_joints(read, chain)
    rms_m = float(np.sqrt(np.mean(left**2)))
    texts = texts_of(change, chain)
    reason = (
        f"joint springs leave {1e3 * rms_m:.3g} of {1e3 * float(np.sqrt(np.mean(measured**2))):.3g} mm of the "
        f"deflections, and {1e3 * rms_m * np.sqrt((1.0 - share) / max(1.0 - explained, 1e-300)):.3g} mm with "
        f"{texts.words}"
    )
    return Fault(
        code_of(change), places.file, _place(change, texts.place, places), reason, texts.mend, changes=(change,)
    )


def _place(change: InputChange, place: str, places: TablePlaces) -> str:
    if change.kind in (ChangeKind.ACTS_ON, ChangeKind.SENSOR_AXES):
        return places.wrench
    if change.kind is ChangeKind.WRENCH_COLUMNS:
        return f"{places.wrench}.columns"
    if change.kind in (ChangeKind.WRENCH_SIGN, ChangeKind.DISPLACEMENT_AXES, ChangeKind.ROW_ORDER):
        return place
    # joints, or a key of the manifest
    return f"{places.joints}: {place}" if change.names else f"{places.joints}.{place}"


def _some(count: int) -> Integers:
    return np.unique(np.linspace(0, count - 1, min(count, MOST_STATES)).astype(np.int64))


def _count_poses(states: LoadStates) -> int:
    return len(np.unique(np.round(states.joints / SAME_POSE_RAD), axis=0))


def _readings(read: LoadStates, chain: Chain, stated: Floats, places: TablePlaces) -> Iterator[_Reading]:
    """Yield the states as they are if angles, loads or displacements are read in another way."""
    for counted in (*counted_otherwise(read.joints, chain, stated), *other_zeros(read, chain)):
        yield _Reading(replace(read, joints=counted.joints), counted.change)
    if _shows_loads(read):
        yield from _other_loads(read, places)
        yield from _other_axes(read)


def _other_loads(read: LoadStates, places: TablePlaces) -> Iterator[_Reading]:
    """Yield the load of the other side, the sensor upside down, one force with the other sign, columns interchanged."""
    opposite = "robot" if places.acts_on == "environment" else "environment"
    yield _Reading(replace(read, wrench=-read.wrench), InputChange(ChangeKind.ACTS_ON, value=opposite))
    for k, axis in enumerate("xyz"):
        signs = np.where(np.arange(6) % 3 == k, 1.0, -1.0)
        change = InputChange(ChangeKind.SENSOR_AXES, (axis,), (np.pi,))
        yield _Reading(replace(read, wrench=read.wrench * signs), change)
    for k, name in enumerate(places.columns[:3]):
        wrench = read.wrench * np.where(np.arange(6) == k, -1.0, 1.0)
        yield _Reading(replace(read, wrench=wrench), InputChange(ChangeKind.WRENCH_SIGN, (name,)))
    for components, names in column_orders(places.columns):
        change = InputChange(ChangeKind.WRENCH_COLUMNS, names)
        yield _Reading(replace(read, wrench=read.wrench[:, components]), change)


def _other_axes(read: LoadStates) -> Iterator[_Reading]:
    """Yield the displacements with their axes in another order, or with other signs."""
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            # nothing is changed, or all of the load acts the other way
            if order == (0, 1, 2) and abs(sum(signs)) == 3.0:
                continue
            deflection = read.deflection.copy()
            deflection[:, :, :3] = deflection[:, :, order] * np.array(signs)
            axes = tuple(f"{'-' if sign < 0.0 else ''}{'XYZ'[k]}" for k, sign in zip(order, signs, strict=True))
            yield _Reading(replace(read, deflection=deflection), InputChange(ChangeKind.DISPLACEMENT_AXES, axes))


def _other_rows(states: LoadStates, some: Integers, chain: Chain) -> Iterator[_Reading]:
    """Yield displacements and loads some rows further down or up; a row that none reaches is left out.

    A joint with a memory (play, creep, friction) lags behind its load as if rows of a pose were moved. So those
    displacements have to follow their loads better, too, that would belong to another pose than their row's, or whose
    load does.
    """
    if not _shows_loads(states.select(some)):
        return
    for by in (step for n in range(1, MOST_ROWS_MOVED + 1) for step in (n, -n)):
        inner = some[(np.minimum(some - by, some + by) >= 0) & (np.maximum(some - by, some + by) < len(states))]
        of_others = np.any(np.abs(states.joints[inner + by] - states.joints[inner]) > SAME_POSE_RAD, axis=1)
        edges = inner[of_others]
        as_read = explained_by_joints(states.select(edges), chain) if len(edges) else 1.0
        for moved in ("displacements", "loads"):
            at_edges = _moved(states, edges + by if moved == "displacements" else edges, by, moved)
            holds = bool(len(edges)) and _is_better(as_read, explained_by_joints(at_edges, chain), at_edges, chain)
            change = InputChange(ChangeKind.ROW_ORDER, (moved,), (float(by),))
            yield _Reading(_moved(states, inner, by, moved), change, holds)


def _moved(states: LoadStates, rows: Integers, by: int, moved: str) -> LoadStates:
    """Return some rows with the displacements or the loads that stand so many rows further up."""
    read = states.select(rows)
    if moved == "loads":
        return replace(read, wrench=states.wrench[rows - by])
    return replace(read, deflection=states.deflection[rows - by])


def _shows_loads(read: LoadStates) -> bool:
    """Return whether displacements were measured under enough different loads to compare them with these."""
    return read.deflection_given and len(np.unique(read.run)) >= LEAST_POSES and count_loads(read) >= LEAST_POSES


def _is_better(explained: float, share: float, states: LoadStates, chain: Chain, tried: int = 1) -> bool:
    """Return whether springs explain by so much more that it is no chance among the readings that were tried."""
    return share > max(FOLLOWS, explained) and chance_of(explained, share, states, chain) * tried <= BY_CHANCE


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
