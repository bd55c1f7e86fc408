"""Which columns of a table of states without a header are joints, places, forces and displacements: one choice fits.

A robot's kinematics meets the places that a tracker measured with one choice of joint columns, or its joints' springs
explain the displacements under the forces with one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.like_poses import SAME_POSE_RAD, pose_groups
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.table_layout.layout import NAMELESS
from stiffcal.wording import length, percent

# Beyond one turn and a bit a number is no radian; no displacement under load is as large; places of a robot are closer
# in m. As for columns whose names are known but not their units.
LARGEST_RADIAN, LARGEST_DEFLECTION_MM, _LARGEST_POSITION_M = 6.6, 50.0, 20.0
# Of the range of a force: the reading without a load.
UNLOADED = 0.1
# Kinematics meets a measured target within some 20 mm (physics, section 0), over poses that lie ten times further
# apart than that: by chance nothing does.
_MEETS_M, _APART_M = 0.02, 0.2
# Unknowns of each coordinate of a place: nine of a rotation with the target's offset, three of the flange's place, one.
_UNKNOWNS = 13
# As for axes of a force: a load that the joints' springs answer leaves less than a fifth of the deflection, and another
# choice of columns four times as much.
_FOLLOWS, _CLEARLY = 0.8, 4.0


def of_states(columns: Sequence[SniffedColumn], chain: Chain, tool: Floats) -> Roles:
    """Return joints with places, or joints with loads and displacements, where one choice of columns explains them."""
    met: list[tuple[float, Role, Role]] = []
    loaded: list[tuple[float, Role, Role, Role]] = []
    for joints in _joint_blocks(columns, chain):
        angles = _angles(joints, chain)
        others = [column for column in columns if column not in joints]
        triples = list(_triples(others))
        met += [
            (distance, Role(joints), Role(place))
            for place in triples
            if (distance := _meets(chain, angles, _metres(place))) is not None
        ]
        attachment = Attachment(chain.n_joints, _moved(chain.flange, tool))
        arms = jacobians(chain, angles, attachment)
        for force in triples:
            loaded += [
                (share, Role(joints), Role(force), Role(moved))
                for moved in triples
                if not set(force) & set(moved)
                and max(column.size for column in moved) < LARGEST_DEFLECTION_MM
                and (share := _explained(arms, numbers_of(force), numbers_of(moved))) > 0.0
            ]
    if met:
        return _with_places(min(met, key=lambda entry: entry[0]), columns, chain) if len(met) == 1 else Roles()
    loaded.sort(key=lambda entry: -entry[0])
    if loaded and loaded[0][0] >= _FOLLOWS:
        share, joints_role, force_role, moved_role = loaded[0]
        if len(loaded) == 1 or 1.0 - loaded[1][0] > _CLEARLY * (1.0 - share):
            why = f"the joints' springs explain {percent(share)} of the displacements with no other columns"
            return Roles(
                joints=replace(joints_role, doubt=why),
                force=replace(force_role, doubt=why),
                deflection=replace(moved_role, doubt=why),
            )
    return Roles()


def _with_places(met: tuple[float, Role, Role], columns: Sequence[SniffedColumn], chain: Chain) -> Roles:
    """Return joints and places, and the force by which the places of one pose differ, where there is one."""
    distance, joints, place = met
    why = f"kinematics meets these places within {length(distance, digits=2)} with no other columns"
    found = Roles(joints=replace(joints, doubt=why), position=replace(place, doubt=why))
    others = [column for column in columns if column not in joints.columns + place.columns]
    pose = pose_groups(_angles(joints.columns, chain), SAME_POSE_RAD)
    forces = [triple for triple in _triples(others) if _loads_poses(numbers_of(triple), pose)]
    if len(forces) == 1:
        return replace(found, force=Role(forces[0], doubt="zero in one row of each pose"))
    angles, metres = _angles(joints.columns, chain), _metres(place.columns)
    masses = [column for column in others if _can_be_mass(column) and _sags(chain, angles, metres, column)]
    if len(masses) == 1:
        return replace(found, mass=Role((masses[0],), doubt="the joints give way under such weights"))
    return found


# Weights that are hung on are a few, or none.
_MOST_WEIGHTS = 12
# Of an F-test with three to six more unknowns, which chance exceeds in fewer than one of 10 000 tables.
_SAGS_F = 8.0


def _can_be_mass(column: SniffedColumn) -> bool:
    return min(column.values) >= 0.0 and 1 < len(set(column.values)) <= _MOST_WEIGHTS


def _sags(chain: Chain, angles: Floats, place: Floats, column: SniffedColumn) -> bool:
    """Return whether springs of the joints under a column of weights explain part of what kinematics leaves."""
    flange = Attachment(chain.n_joints, chain.flange)
    arm = jacobians(chain, angles, flange)[:, :3]
    force = np.outer(column.values, chain.gravity)
    sag = arm * np.einsum("npj,np->nj", arm, force)[:, None, :]
    fixed = _of_poses(chain, angles)
    matrix = np.kron(fixed, np.eye(3))
    both = np.hstack([matrix, sag.reshape(-1, chain.n_joints)])
    wanted = place.reshape(-1)
    without, with_sag = (wanted - own @ np.linalg.lstsq(own, wanted, rcond=1e-10)[0] for own in (matrix, both))
    rank = np.linalg.matrix_rank(both) - np.linalg.matrix_rank(matrix)
    if not rank:
        return False
    freedom = wanted.size - both.shape[1]
    gained = float(without @ without - with_sag @ with_sag)
    return bool(gained / rank > _SAGS_F * float(with_sag @ with_sag) / freedom)


def _loads_poses(force: Floats, pose: Integers) -> bool:
    """Return whether three columns are near zero in one row of each repeated pose, and large in another."""
    size = np.linalg.norm(force, axis=1)
    shared = [size[pose == group] for group in np.flatnonzero(np.bincount(pose) > 1)]
    return bool(shared) and all(own.min() < UNLOADED * own.max() for own in shared)


def _joint_blocks(columns: Sequence[SniffedColumn], chain: Chain) -> Iterator[tuple[SniffedColumn, ...]]:
    """Yield the runs of neighbouring columns that can be the joints: as many, within their limits, in several poses."""
    n = chain.n_joints
    for first in range(len(columns) - n + 1):
        block = tuple(columns[first : first + n])
        if any(len(set(column.values)) > 1 for column in block) and within_limits(block, chain):
            yield block


def within_limits(block: Sequence[SniffedColumn], chain: Chain) -> bool:
    """Return whether columns stay within the limits of a robot's joints, in degrees or radians."""
    drives = _angles(block, chain, modelled=False)
    low, high = chain.limits.T
    return bool(np.all((drives >= low - SAME_POSE_RAD) & (drives <= high + SAME_POSE_RAD)))


def _angles(block: Sequence[SniffedColumn], chain: Chain, modelled: bool = True) -> Floats:
    """Return (n, J) joint positions, rad, and m of prismatic joints, of columns in degrees or radians, mm or m."""
    turning = [column for k, column in enumerate(block) if not chain.prismatic[k]]
    degrees = max((column.size for column in turning), default=0.0) > LARGEST_RADIAN
    turn = np.pi / 180.0 if degrees else 1.0
    factors = [
        turn if not chain.prismatic[k] else 1e-3 if column.size > _LARGEST_POSITION_M else 1.0
        for k, column in enumerate(block)
    ]
    logged = numbers_of(block) * np.array(factors)
    return chain.model_angles(logged) if modelled else logged


def _triples(columns: Sequence[SniffedColumn]) -> Iterator[tuple[SniffedColumn, ...]]:
    """Yield three neighbouring columns each that change."""
    for first in range(len(columns) - 2):
        triple = tuple(columns[first : first + 3])
        if all(len(set(column.values)) > 1 for column in triple) and _are_neighbours(triple):
            yield triple


def _are_neighbours(columns: Sequence[SniffedColumn]) -> bool:
    numbers = [int(column.header.removeprefix(NAMELESS)) for column in columns]
    return bool(np.all(np.diff(numbers) == 1))


def numbers_of(columns: Sequence[SniffedColumn]) -> Floats:
    """Return (n, c) the values of columns that are equally long."""
    return np.array([column.values for column in columns], dtype=np.float64).T


def _metres(place: Sequence[SniffedColumn]) -> Floats:
    return numbers_of(place) * (1e-3 if max(column.size for column in place) >= _LARGEST_POSITION_M else 1.0)


def _moved(flange: Floats, tool: Floats) -> Floats:
    placed = flange.copy()
    placed[:3, 3] += flange[:3, :3] @ tool
    return placed


def _meets(chain: Chain, angles: Floats, place: Floats) -> float | None:
    """Return the distance that kinematics leaves to measured places, m, rms; None where it does not meet them.

    Each coordinate is a constant, and linear in the place and the rotation of the last body, whatever the tracker's
    frame and the target's offset on the flange are.
    """
    if len(place) < 2 * _UNKNOWNS or float(np.sqrt(place.var(axis=0).sum())) < _APART_M:
        return None
    matrix = _of_poses(chain, angles)
    solution, *_ = np.linalg.lstsq(matrix, place, rcond=1e-10)
    left = place - matrix @ solution
    distance = float(np.sqrt(np.sum(left**2) / (len(place) - _UNKNOWNS)))
    return distance if distance < _MEETS_M else None


def _of_poses(chain: Chain, angles: Floats) -> Floats:
    """Return (n, 13) what each coordinate of a target's place is linear in."""
    at, turned = attached_poses(chain, angles, Attachment(chain.n_joints, chain.flange))
    return np.column_stack([at, turned.reshape(len(angles), 9), np.ones(len(angles))])


def _explained(arms: Floats, force: Floats, moved: Floats) -> float:
    """Return the share of displacements that springs of the joints explain, none of them negative."""
    if len(force) <= arms.shape[-1]:
        return 0.0
    moved = moved / max(float(np.abs(moved).max()), 1e-300)
    arm = arms[:, :3]
    torque = np.einsum("npj,np->nj", arm, force)
    matrix = (arm * torque[:, None, :]).reshape(-1, arms.shape[-1])
    wanted = moved.reshape(-1)
    count = arms.shape[-1]
    soft, _ = least_squares_within(matrix, wanted, np.zeros(count), np.full(count, np.inf))
    return 1.0 - float(np.sum((matrix @ soft - wanted) ** 2) / np.sum(wanted**2))
