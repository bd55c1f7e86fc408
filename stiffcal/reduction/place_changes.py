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
from stiffcal.escapes import toml_text
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.angle_conventions import coupled_angles
from stiffcal.reduction.met_places import MeasuredPlaces, orders, places_of

LENGTH_FACTORS = {
    1e-3: "a thousand times too large",
    1e3: "a thousand times too small",
    1e-1: "ten times too large",
    1e1: "ten times too small",
    1e-2: "a hundred times too large",
    1e2: "a hundred times too small",
    25.4: "in inches",
    1.0 / 25.4: "in millimetres",
}
# Of some rows, the unit that the others have.
OTHER_UNIT = {25.4: " where the others are in millimetres", 1.0 / 25.4: " where the others are in inches"}
# The factor, the unit that the angles are in, the unit that the others are in.
ANGLE_FACTORS = ((np.pi / 180.0, "degrees", "radians", "deg"), (180.0 / np.pi, "radians", "degrees", "rad"))
# What is added to the logged angle, and by how much that is then too large.
TURNS = {np.pi / 2: ("90°", "90° too small"), -np.pi / 2: ("−90°", "90° too large"), np.pi: ("180°", "off by 180°")}
AXES = "XYZ"
# By so many rows at most the places of a table are taken to be moved against the joint angles.
MOST_ROWS_MOVED = 3


@dataclass(frozen=True)
class PlaceChange:
    """A change of the rows."""

    code: FaultCode
    places: MeasuredPlaces
    """With the change in all rows."""
    place: str = ""
    """Of the mistake, where all rows have it."""
    words: str = ""
    """As in "with … they miss by less", where all rows have it."""
    mend: str = ""
    """The same."""
    in_rows: str = ""
    """What is wrong where some rows have it."""
    mend_rows: str = ""
    """What to do about these, where it is not the usual."""
    of_angles: bool = False
    """Whether joint angles are wrong, not positions."""
    of_all: bool = True
    """Whether all rows can have the mistake: what frames and targets take up can be that of some rows alone."""
    file: Literal["table", "manifest", "robot"] = "table"
    """In which file the place is, where all rows have the mistake."""
    change: InputChange | None = None
    """The same as values; None where it is no change of a joint's angles or of the order of rows."""


def changes_of_rows(states: LoadStates, chain: Chain, places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield the changes that some rows or all may need.

    Parameters
    ----------
    states : n rows. places : theirs. chain : the robot's kinematics.
    """
    yield from _lengths(states, places)
    for order in orders(places.measured.shape[1]):
        moved = [states.setup.target_names[b] for b in range(len(order)) if order[b] != b]
        yield PlaceChange(
            FaultCode.KINEMATICS_MISMATCH, replace(places, measured=places.measured[:, order]),
            in_rows=f"the positions of {listed(moved)} are interchanged",
            mend_rows="interchange their columns there, or exclude these rows with [[exclude]]", of_all=False,
        )  # fmt: skip
    yield from _angles(states, chain)
    yield from _axes(states, places)


def changes_of_the_table(
    states: LoadStates, chain: Chain, places: MeasuredPlaces, robot: RobotFile, folder: Path
) -> Iterator[PlaceChange]:
    """Yield the changes that all rows may need.

    Parameters
    ----------
    states : n rows. places : theirs. chain : the robot's kinematics. robot : its file, in ``folder``.
    """
    rows = [change for change in changes_of_rows(states, chain, places) if change.of_all]
    yield from sorted(rows, key=lambda change: not change.of_angles)
    mirrored = places.measured * np.array([1.0, 1.0, -1.0])
    yield PlaceChange(
        FaultCode.KINEMATICS_MISMATCH, replace(places, measured=mirrored), "columns of the positions",
        "the positions mirrored",
        "two of the columns X, Y and Z are interchanged, or one has the wrong sign: correct them",
    )  # fmt: skip
    joints = states.joints * -1.0
    yield PlaceChange(
        FaultCode.KINEMATICS_MISMATCH, places_of(replace(states, joints=joints), chain), "joints",
        "the signs of all joints changed",
        "change the sign of direction of all joints in robot.toml, or of the columns of their angles",
        of_angles=True,
    )  # fmt: skip
    for other, where, words, mend in _other_robots(robot):
        yield PlaceChange(
            FaultCode.KINEMATICS_MISMATCH, places_of(states, chain_of(other, folder)), where, words, mend,
            file="robot",
        )  # fmt: skip


def moved_positions(places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield the table with all positions moved some rows too high or too low against the joint angles, or reversed."""
    code, place = FaultCode.KINEMATICS_MISMATCH, "the order of the rows"
    for n in range(1, min(MOST_ROWS_MOVED, len(places.measured) - 1) + 1):
        rows = "one row" if n == 1 else f"{n} rows"
        for direction in ("down", "up"):
            moved = np.full_like(places.measured, np.nan)
            if direction == "down":
                moved[n:] = places.measured[:-n]
            else:
                moved[:-n] = places.measured[n:]
            yield PlaceChange(
                code, replace(places, measured=moved), place, f"all places moved {direction} by {rows}",
                f"move the columns of the places {direction} by {rows} against those of the joint angles",
                change=InputChange(ChangeKind.POSE_ORDER, sizes=(float(n if direction == "down" else -n),)),
            )  # fmt: skip
    yield PlaceChange(
        code, replace(places, measured=places.measured[::-1]), place, "the order of the positions reversed",
        "reverse the rows of the places against those of the joint angles",
    )  # fmt: skip


def listed(names: list[str]) -> str:
    """Return names as a sentence lists them."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def _lengths(states: LoadStates, places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield positions in another unit: of all targets, of one, of one axis."""
    names = states.setup.target_names
    code, measured = FaultCode.UNIT_IMPLAUSIBLE, places.measured
    for factor, words in LENGTH_FACTORS.items():
        yield PlaceChange(
            code, replace(places, measured=factor * measured), "units.position", f"places multiplied by {factor:.4g}",
            f"all positions are {words}: correct units of the position",
            f"the positions are {words}{OTHER_UNIT.get(factor, '')}", file="manifest",
        )  # fmt: skip
        for b, name in enumerate(names if len(names) > 1 else ()):
            one = measured.copy()
            one[:, b] *= factor
            yield PlaceChange(
                code, replace(places, measured=one), f"poses.{name}.units.position",
                f"the positions of {name} multiplied by {factor:.4g}",
                f"the positions of {name} are {words}: correct the unit of that target",
                f"the positions of {name} are {words}{OTHER_UNIT.get(factor, '')}", file="manifest",
            )  # fmt: skip
    for k, axis in enumerate(AXES):
        for factor in (1e3, 1e-3):
            one = measured.copy()
            one[..., k] *= factor
            yield PlaceChange(
                code, replace(places, measured=one), f"columns {axis} of the positions",
                f"{axis} of the positions multiplied by {factor:.4g}",
                f"{axis} of all positions is {LENGTH_FACTORS[factor]}: correct its column",
                f"{axis} of the positions is {LENGTH_FACTORS[factor]}",
            )  # fmt: skip


def _angles(states: LoadStates, chain: Chain) -> Iterator[PlaceChange]:
    """Yield other signs, zeros, units and columns of joint angles."""

    def with_angles(joints: Floats) -> MeasuredPlaces:
        return places_of(replace(states, joints=joints), chain)

    def with_joint(joint: int, sign: float, turn: float) -> MeasuredPlaces:
        joints = states.joints.copy()
        joints[:, joint] = sign * joints[:, joint] + turn
        return with_angles(joints)

    code, names, slides = FaultCode.KINEMATICS_MISMATCH, chain.joint_names, chain.prismatic
    turning = [(joint, name) for joint, name in enumerate(names) if not slides[joint]]
    for joint, name in enumerate(names):
        what = "position" if slides[joint] else "angle"
        yield PlaceChange(
            code, with_joint(joint, -1.0, 0.0), f"joint {name}", f"the sign of joint {name} changed",
            f"change the sign of direction of joint {name} in robot.toml, or of the column of its {what}",
            f"the {what} of joint {name} has the wrong sign", of_angles=True,
            change=InputChange(ChangeKind.DIRECTION, (name,)),
        )  # fmt: skip
        for factor in (1e3, 1e-3) if slides[joint] else ():
            yield PlaceChange(
                FaultCode.UNIT_IMPLAUSIBLE, with_joint(joint, factor, 0.0), f"joint {name}",
                f"the position of joint {name} multiplied by {factor:g}",
                f"the positions of joint {name} are {LENGTH_FACTORS[factor]}: correct the unit of its column",
                f"the position of joint {name} is {LENGTH_FACTORS[factor]}", of_angles=True,
            )  # fmt: skip
    for turn, (words, off) in TURNS.items():
        for joint, name in turning:
            yield PlaceChange(
                code, with_joint(joint, 1.0, turn), f"joint {name}", f"the zero of joint {name} moved by {words}",
                f"correct theta_deg of joint {name} in robot.toml by {words}, or the column of its angle",
                f"the angle of joint {name} is {off}", of_angles=True,
                change=InputChange(ChangeKind.ZERO, (name,), (turn,)),
            )  # fmt: skip
    for factor, words, others, unit in ANGLE_FACTORS:
        turned = np.where(slides, 1.0, factor) * states.joints
        yield PlaceChange(
            FaultCode.UNIT_IMPLAUSIBLE, with_angles(turned), "joints.units.position",
            f"joint angles read as {words}", f"all joint angles are in {words}: correct units of the joints",
            f"joint angles are in {words} where the others are in {others}", of_angles=True, file="manifest",
            change=InputChange(ChangeKind.ANGLE_UNIT, value=unit),
        )  # fmt: skip
        for joint, name in turning:
            yield PlaceChange(
                FaultCode.UNIT_IMPLAUSIBLE, with_joint(joint, factor, 0.0), f"joint {name}",
                f"the angle of joint {name} read as {words}",
                f"the angles of joint {name} are in {words}: correct their column",
                f"the angle of joint {name} is in {words} where the others are in {others}", of_angles=True,
                change=InputChange(ChangeKind.ANGLE_UNIT, (name,), value=unit),
            )  # fmt: skip
    for coupled in coupled_angles(states.joints, chain):
        yield PlaceChange(
            code, with_angles(coupled.joints), coupled.place, coupled.words, coupled.mend,
            f"the angles of {coupled.place} are counted together where those of the others are not", of_angles=True,
            change=coupled.change,
        )  # fmt: skip
    for first, second in combinations(range(len(names)), 2):
        joints = states.joints.copy()
        joints[:, [first, second]] = joints[:, [second, first]]
        pair = f"{names[first]} and {names[second]}"
        yield PlaceChange(
            code, with_angles(joints), f"joints {pair}", f"the angles of joints {pair} interchanged",
            f"interchange the columns of joints {pair}", f"the angles of joints {pair} are interchanged",
            of_angles=True, change=InputChange(ChangeKind.JOINT_ORDER, (names[second], names[first])),
        )  # fmt: skip
    yield PlaceChange(
        code, with_angles(states.joints[:, ::-1]), "joints", "the order of the joints reversed",
        "reverse the order of the columns of the joint angles", "the order of the joint angles is reversed",
        of_angles=True,
    )  # fmt: skip


def _axes(states: LoadStates, places: MeasuredPlaces) -> Iterator[PlaceChange]:
    """Yield positions with interchanged axes or another sign of one, of all targets or of one.

    Of all rows and targets, all of these are one mirror but for a turn, which the estimated frame takes.
    """
    names, measured = states.setup.target_names, places.measured
    swapped = {
        a + b: np.eye(3)[[AXES.index({a: b, b: a}.get(axis, axis)) for axis in AXES]] for a, b in combinations(AXES, 2)
    }
    ways = [(f"{axes[0]} and {axes[1]}", "are interchanged", "interchanged", m) for axes, m in swapped.items()]
    for k, axis in enumerate(AXES):
        ways.append(
            (axis, "has the wrong sign", "with the other sign", np.diag(np.where(np.arange(3) == k, -1.0, 1.0)))
        )
    which = [None, *range(len(names))] if len(names) > 1 else [None]
    for target in which:
        of = "of the positions" if target is None else f"of {names[target]}"
        for axes, wrong, undone, matrix in ways:
            changed = measured.copy()
            chosen = slice(None) if target is None else slice(target, target + 1)
            changed[:, chosen] = changed[:, chosen] @ matrix
            yield PlaceChange(
                FaultCode.KINEMATICS_MISMATCH, replace(places, measured=changed), f"columns {axes} {of}",
                "" if target is None else f"{axes} {of} {undone}", f"correct the columns {axes} {of}",
                f"{axes} {of} {wrong}", of_all=target is not None,
            )  # fmt: skip


def _other_robots(robot: RobotFile) -> Iterator[tuple[RobotFile, str, str, str]]:
    """Yield robot files with the other convention or the other sign of one entry, their place, words and mend."""
    if robot.convention is None:
        return
    other = "dh" if robot.convention == "modified-dh" else "modified-dh"
    line = toml_text.pair("convention", other)
    yield robot.model_copy(update={"convention": other}), "convention", line, f"write {line} in the robot file"
    for k, joint in enumerate(robot.joints):
        for key in ("a_m", "d_m", "alpha_deg"):
            value = getattr(joint, key)
            # half a turn is its own negative
            if value == 0.0 or (key == "alpha_deg" and abs(value) == 180.0):
                continue
            changed = joint.model_copy(update={key: -value})
            joints = tuple(changed if j == k else entry for j, entry in enumerate(robot.joints))
            yield (
                robot.model_copy(update={"joints": joints}), f"joints[{k + 1}] ({joint.name}).{key}",
                f"{key} = {-value:g} of joint {joint.name}", f"change the sign of {key} of joint {joint.name}",
            )  # fmt: skip
