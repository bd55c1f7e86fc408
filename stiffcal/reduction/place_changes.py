"""Changes of joint angles, positions or the robot file that are tried on absolute places that do not meet.

A change of joint angles or positions may be that of a whole table, or of some of its rows; of the robot file it is that
of all rows. The likeliest mistakes come first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.geometry import chain_of
from stiffcal.campaign.robot_file import RobotFile
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.angle_conventions import counted_otherwise, logged_names
from stiffcal.reduction.change_texts import LENGTH_FACTORS
from stiffcal.reduction.met_places import MeasuredPlaces, orders, places_of

# What is added to the logged angle.
TURNS = (np.pi / 2, -np.pi / 2, np.pi)
AXES = "XYZ"
# By so many rows at most the places of a table are taken to be moved against the joint angles.
MOST_ROWS_MOVED = 3
_OF_ANGLES = (
    ChangeKind.DIRECTION,
    ChangeKind.JOINT_UNIT,
    ChangeKind.ZERO,
    ChangeKind.ANGLE_UNIT,
    ChangeKind.COUNTED_TOGETHER,
    ChangeKind.JOINT_ORDER,
)
_OF_ROBOT = (ChangeKind.ROBOT_CONVENTION, ChangeKind.ROBOT_SIGN)


@dataclass(frozen=True)
class PlaceChange:
    """A change of the rows."""

    change: InputChange
    places: MeasuredPlaces
    """With the change in all rows."""
    of_all: bool = True
    """Whether all rows can have the mistake: what frames and targets take up can be that of some rows alone."""

    @property
    def of_angles(self) -> bool:
        """Whether joint angles are wrong, not positions."""
        return self.change.kind in _OF_ANGLES

    @property
    def file(self) -> Literal["table", "manifest", "robot"]:
        """In which file the mistake is, where all rows have it."""
        if self.change.kind in _OF_ROBOT:
            return "robot"
        of_unit = self.change.kind is ChangeKind.ANGLE_UNIT
        of_length = self.change.kind is ChangeKind.LENGTH_FACTOR and not self.change.value
        return "manifest" if of_unit or of_length else "table"


def changes_of_rows(states: LoadStates, chain: Chain, places: MeasuredPlaces, stated: Floats) -> Iterator[PlaceChange]:
    """Yield the changes that some rows or all may need.

    Parameters
    ----------
    states : n rows. places : theirs. chain : the robot's kinematics.
    stated : (L,) rad, the unit that the manifest states of the logged angles.
    """
    yield from _lengths(states, places)
    for order in orders(places.measured.shape[1]):
        moved = tuple(states.setup.target_names[b] for b in range(len(order)) if order[b] != b)
        exchanged = replace(places, measured=places.measured[:, order])
        yield PlaceChange(InputChange(ChangeKind.TARGET_ORDER, moved), exchanged, of_all=False)
    yield from _angles(states, chain, stated)
    yield from _axes(states, places)


def changes_of_the_table(
    states: LoadStates, chain: Chain, places: MeasuredPlaces, stated: Floats, robot: RobotFile, folder: Path
) -> Iterator[PlaceChange]:
    """Yield the changes that all rows may need.

    Parameters
    ----------
    states : n rows. places : theirs. chain : the robot's kinematics. robot : its file, in ``folder``.
    stated : (L,) rad, the unit that the manifest states of the logged angles.
    """
    rows = [change for change in changes_of_rows(states, chain, places, stated) if change.of_all]
    yield from sorted(rows, key=lambda change: not change.of_angles)
    mirrored = replace(places, measured=places.measured * np.array([1.0, 1.0, -1.0]))
    yield PlaceChange(InputChange(ChangeKind.MIRRORED), mirrored)
    all_signs = InputChange(ChangeKind.DIRECTION, logged_names(states.joints, chain))
    yield PlaceChange(all_signs, places_of(replace(states, joints=-states.joints), chain))
    for other, change in _other_robots(robot):
        yield PlaceChange(change, places_of(states, chain_of(other, folder)))


def moved_positions(places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield the table with all positions moved some rows too high or too low against the joint angles, or reversed."""
    for n in range(1, min(MOST_ROWS_MOVED, len(places.measured) - 1) + 1):
        for by in (n, -n):
            moved = np.full_like(places.measured, np.nan)
            if by > 0:
                moved[n:] = places.measured[:-n]
            else:
                moved[:-n] = places.measured[n:]
            change = InputChange(ChangeKind.ROW_ORDER, ("positions",), (float(by),))
            yield PlaceChange(change, replace(places, measured=moved))
    reverse = replace(places, measured=places.measured[::-1])
    yield PlaceChange(InputChange(ChangeKind.ROW_ORDER, ("positions",)), reverse)


def _lengths(states: LoadStates, places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield positions in another unit: of all targets, of one, of one axis."""
    names, measured = states.setup.target_names, places.measured
    for factor in LENGTH_FACTORS:
        change = InputChange(ChangeKind.LENGTH_FACTOR, sizes=(factor,))
        yield PlaceChange(change, replace(places, measured=factor * measured))
        for b, name in enumerate(names if len(names) > 1 else ()):
            one = measured.copy()
            one[:, b] *= factor
            yield PlaceChange(replace(change, names=(name,)), replace(places, measured=one))
    for k, axis in enumerate(AXES):
        for factor in (1e3, 1e-3):
            one = measured.copy()
            one[..., k] *= factor
            change = InputChange(ChangeKind.LENGTH_FACTOR, sizes=(factor,), value=axis)
            yield PlaceChange(change, replace(places, measured=one))


def _angles(states: LoadStates, chain: Chain, stated: Floats) -> Iterator[PlaceChange]:
    """Yield other signs, units, zeros and columns of joint angles."""
    joints, names = states.joints, logged_names(states.joints, chain)

    def changed(kind: ChangeKind, joint: int, values: Floats, size: tuple[float, ...], value: str = "") -> PlaceChange:
        angles = joints.copy()
        angles[:, joint] = values
        change = InputChange(kind, (names[joint],), size, value)
        return PlaceChange(change, places_of(replace(states, joints=angles), chain))

    for counted in counted_otherwise(joints, chain, stated):
        yield PlaceChange(counted.change, places_of(replace(states, joints=counted.joints), chain))
    for k in range(joints.shape[1]):
        for unit, factor in (("mm", 1e-3), ("m", 1e3)) if chain.prismatic[k] else ():
            yield changed(ChangeKind.JOINT_UNIT, k, factor * joints[:, k], (), unit)
        for turn in () if chain.prismatic[k] else TURNS:
            yield changed(ChangeKind.ZERO, k, joints[:, k] + turn, (turn,))
    reverse = places_of(replace(states, joints=joints[:, ::-1]), chain)
    yield PlaceChange(InputChange(ChangeKind.JOINT_ORDER, names[::-1]), reverse)


def _axes(states: LoadStates, places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield positions with interchanged axes or another sign of one, of all targets or of one.

    Of all rows and targets, all of these are one mirror but for a turn, which the estimated frame takes.
    """
    names, measured = states.setup.target_names, places.measured
    ways = [tuple({a: b, b: a}.get(axis, axis) for axis in AXES) for a, b in combinations(AXES, 2)]
    ways += [tuple(f"-{axis}" if axis == other else axis for axis in AXES) for other in AXES]
    which = [None, *range(len(names))] if len(names) > 1 else [None]
    for target in which:
        of = "" if target is None else names[target]
        chosen = slice(None) if target is None else slice(target, target + 1)
        for axes in ways:
            columns = [AXES.index(axis[-1]) for axis in axes]
            signs = np.array([-1.0 if len(axis) > 1 else 1.0 for axis in axes])
            changed = measured.copy()
            changed[:, chosen] = changed[:, chosen][..., columns] * signs
            change = InputChange(ChangeKind.POSITION_AXES, axes, value=of)
            yield PlaceChange(change, replace(places, measured=changed), of_all=target is not None)


def _other_robots(robot: RobotFile) -> Iterator[tuple[RobotFile, InputChange]]:
    """Yield robot files with the other convention or the other sign of one entry."""
    if robot.convention is None:
        return
    other = "dh" if robot.convention == "modified-dh" else "modified-dh"
    yield robot.model_copy(update={"convention": other}), InputChange(ChangeKind.ROBOT_CONVENTION, value=other)
    for k, joint in enumerate(robot.joints):
        for key in ("a_m", "d_m", "alpha_deg"):
            value = getattr(joint, key)
            # half a turn is its own negative
            if value == 0.0 or (key == "alpha_deg" and abs(value) == 180.0):
                continue
            changed = joint.model_copy(update={key: -value})
            joints = tuple(changed if j == k else entry for j, entry in enumerate(robot.joints))
            change = InputChange(ChangeKind.ROBOT_SIGN, (joint.name,), (-value,), key)
            yield robot.model_copy(update={"joints": joints}), change
