"""A change of the input in words: its place, what would be changed, and what to write or correct.

All texts about a change of a table or of the geometry are made here, from the change and the robot alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import FORCES_ALONE, ChangeKind, InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain

LENGTH_FACTORS = {
    1e-3: "a thousand times too large",
    1e3: "a thousand times too small",
    1e-1: "ten times too large",
    1e1: "ten times too small",
    1e-2: "a hundred times too large",
    1e2: "a hundred times too small",
    25.4: "in inches and read as millimetres",
    1.0 / 25.4: "in millimetres and read as inches",
}
"""Factors that lengths may have to be multiplied by, and what these are without."""
UNIT_WORDS = {
    "deg": "degrees",
    "rad": "radians",
    "rev": "revolutions",
    "mm": "millimetres",
    "in": "inches",
    "m": "metres",
    "arcmin": "arc minutes",
    "arcsec": "arc seconds",
}
"""Units that a sentence spells out."""
_UNITS = (ChangeKind.ANGLE_UNIT, ChangeKind.LENGTH_UNIT, ChangeKind.LENGTH_FACTOR, ChangeKind.JOINT_UNIT)
_OF_LOADS = (
    ChangeKind.ACTS_ON,
    ChangeKind.SENSOR_AXES,
    ChangeKind.WRENCH_COLUMNS,
    ChangeKind.WRENCH_SIGN,
    ChangeKind.DISPLACEMENT_AXES,
)


@dataclass(frozen=True)
class ChangeTexts:
    """A change in words."""

    place: str
    """Of the mistake in its file, as in "joint A2"."""
    words: str
    """What is tried, as in "with … they agree"."""
    mend: str
    """What to write or correct."""
    in_rows: str = ""
    """What is wrong where only some rows have the mistake."""


def texts_of(change: InputChange, chain: Chain) -> ChangeTexts:
    """Return a change in words.

    Parameters
    ----------
    change : what is changed. chain : the robot, for its prismatic joints and for angles that its file counts together.
    """
    return ChangeTexts(*_TEXTS[change.kind](change, chain))


def code_of(change: InputChange) -> FaultCode:
    """Return the code of the fault that a change mends."""
    if change.kind in _UNITS:
        return FaultCode.UNIT_IMPLAUSIBLE
    return FaultCode.WRENCH_MISMATCH if change.kind in _OF_LOADS else FaultCode.KINEMATICS_MISMATCH


def unit_in_words(name: str) -> str:
    """Return a unit as a sentence has it.

    Examples
    --------
    >>> unit_in_words("deg"), unit_in_words("gon")
    ('degrees', 'gon')
    """
    return UNIT_WORDS.get(name, name)


_Texts: TypeAlias = tuple[str, str, str] | tuple[str, str, str, str]


def _angle_unit(change: InputChange, chain: Chain) -> _Texts:
    unit = unit_in_words(change.value)
    mend = f"write {toml_text.pair('units', {'position': change.value})}"
    return "units.position", f"joint angles in {unit}", mend, f"joint angles are in {unit}, those of the others not"


def _length_unit(change: InputChange, chain: Chain) -> _Texts:
    mend = f"write {toml_text.pair('units', {'position': change.value})}"
    return "units.position", f"positions in {change.value}", mend


def _length_factor(change: InputChange, chain: Chain) -> _Texts:
    (factor,) = change.sizes
    wrong = LENGTH_FACTORS[factor]
    if change.value:
        of, place, mend = f"{change.value} of the positions", f"columns {change.value} of the positions", "its column"
        return place, f"{of} multiplied by {factor:.4g}", f"{of} is {wrong}: correct {mend}", f"{of} is {wrong}"
    of = f"the positions of {change.names[0]}" if change.names else "the positions"
    place = f"poses.{change.names[0]}.units.position" if change.names else "units.position"
    mend = f"{of} are {wrong}: correct their unit"
    return place, f"{of} multiplied by {factor:.4g}", mend, f"{of} are {wrong}"


def _target_order(change: InputChange, chain: Chain) -> _Texts:
    of = f"the positions of {listed(change.names)}"
    return f"columns of {listed(change.names)}", f"{of} interchanged", f"interchange {of}", f"{of} are interchanged"


def _position_axes(change: InputChange, chain: Chain) -> _Texts:
    of = f"of {change.value}" if change.value else "of the positions"
    other = [axis for axis, name in zip("XYZ", change.names, strict=True) if axis != name]
    axes = " and ".join(other)
    wrong, undone = "are interchanged", "interchanged"
    if len(other) == 1:
        wrong, undone = "has the wrong sign", "with the other sign"
    return f"columns {axes} {of}", f"{axes} {of} {undone}", f"correct the columns {axes} {of}", f"{axes} {of} {wrong}"


def _mirrored(change: InputChange, chain: Chain) -> _Texts:
    mend = "two of the columns X, Y and Z are interchanged, or one has the wrong sign: correct them"
    return "columns of the positions", "the positions mirrored", mend


def _joint_unit(change: InputChange, chain: Chain) -> _Texts:
    (name,), unit = change.names, unit_in_words(change.value)
    return (
        f"joint {name}",
        f"joint {name} in {unit}",
        f"correct the unit of the column of {name}",
        f"{_reading(name, chain)} is in {unit}, that of the others not",
    )


def _joint_order(change: InputChange, chain: Chain) -> _Texts:
    mend = "name the joint columns from base to wrist"
    if len(change.names) > 2:
        return "joints", "the order of the joints reversed", mend, "the order of the joint angles is reversed"
    pair = f"{change.names[1]} and {change.names[0]}"
    wrong = f"the angles of joints {pair} are interchanged"
    return f"joints {pair}", f"joint columns {pair} interchanged", mend, wrong


def _direction(change: InputChange, chain: Chain) -> _Texts:
    if len(change.names) > 1:
        mend = "change the sign of direction of all joints in the robot file, or of the columns of their angles"
        return "joints", "all joints with opposite direction", mend
    (name,) = change.names
    return (
        f"joint {name}",
        f"joint {name} with opposite direction",
        f"change the sign of direction of joint {name} in the robot file, or of its column",
        f"{_reading(name, chain)} has the wrong sign",
    )


def _reading(name: str, chain: Chain) -> str:
    return f"the {'position' if name in _sliding(chain) else 'angle'} of joint {name}"


def _sliding(chain: Chain) -> set[str]:
    return {name for name, prismatic in zip(chain.joint_names, chain.prismatic, strict=False) if prismatic}


def _counted_together(change: InputChange, chain: Chain) -> _Texts:
    one, other = change.names
    (share,) = change.sizes
    amount = f"{'+' if share > 0.0 else '−'} {'2·' if abs(share) == 2.0 else ''}{one}"
    first, second = chain.joint_names.index(one), chain.joint_names.index(other)
    stated = float(chain.coupling[second, first] / chain.coupling[second, second])
    mend = _mend_of_count(one, other, stated, stated + share, bool(chain.mechanical[second]))
    place = f"joints {one} and {other}"
    wrong = f"the angles of {place} are counted together where those of the others are not"
    return place, f"{other} {amount} in place of {other}", mend, wrong


def _mend_of_count(one: str, other: str, stated: float, counted: float, mechanical: bool) -> str:
    """Return what to write where a robot file counts joint ``other`` with ``stated`` times joint ``one`` before it."""
    if not stated:
        return (
            f"the table counts {other} together with {one}, as controllers do against the horizontal: write "
            f"{toml_text.pair('logged', {one: int(counted), other: 1})} for joint {other} in the robot file"
        )
    if counted:
        return f"{one} counts with the other sign: change its sign in `logged` of joint {other} in the robot file"
    if mechanical:
        # its spring stays on the axis that the rod holds, which the robot file describes by `logged` as well
        sign = "−" if stated > 0.0 else "+"
        return (
            f"the table counts {other} against the link before it, where the robot file has a rod that holds it: give "
            f"the column of {other} as {other} {sign} {one}"
        )
    return (
        f"the table counts {other} by itself, as against the link before it: remove {one} from `logged` of joint "
        f"{other} in the robot file"
    )


def _zeros(change: InputChange, chain: Chain) -> _Texts:
    slides = _sliding(chain)
    parts = [
        f"{1e3 * size:+.2f} mm at joint {name}" if name in slides else f"{np.degrees(size):+.2f}° at joint {name}"
        for name, size in zip(change.names, change.sizes, strict=True)
    ]
    keys = sorted({"d_m" if name in slides else "theta_deg" for name in change.names}, reverse=True)
    one = len(change.names) == 1
    mend = f"correct {' and '.join(keys)} in the robot file by this, or the zero of the controller"
    wrong = f"{_reading(change.names[0], chain)} lacks {parts[0].partition(' at ')[0]}" if one else ""
    return f"joint {change.names[0]}" if one else "joints", f"other zeros: {', '.join(parts)}", mend, wrong


def _tracker_frame(change: InputChange, chain: Chain) -> _Texts:
    turn, shift = np.array(change.sizes[:3]), change.sizes[3:]
    angle = float(np.linalg.norm(turn))
    about = ", ".join(f"{part:.2f}" for part in turn / max(angle, 1e-12))
    words = (
        f"the tracker frame rotated by {np.degrees(angle):.2g}° about ({about}) through the centre of the positions "
        f"and moved by ({_millimetres(shift)}) mm in base axes"
    )
    mend = "correct the tracker's frame, or write estimate = true there to estimate it from these poses"
    return "frames.tracker", words, mend


def _target(change: InputChange, chain: Chain) -> _Texts:
    words = f"the target moved by ({_millimetres(change.sizes)}) mm in its own axes"
    mend = "correct the target's frame, or write estimate = true there to estimate it from these poses"
    return "frames", words, mend


def _tracker_axes(change: InputChange, chain: Chain) -> _Texts:
    words = f"the tracker's axes as ({', '.join(change.names)})"
    return "columns of the positions", words, "correct the order of position's columns, or the frame"


def _inverse_frame(change: InputChange, chain: Chain) -> _Texts:
    mend = "frames.tracker is the pose of the tracker in the base frame, not of the base in the tracker frame"
    return "frames.tracker", "the inverse of the tracker frame", mend


def _pose_order(change: InputChange, chain: Chain) -> _Texts:
    pairs = [
        f"“{own}” has the position of “{other}”"
        for own, other in zip(change.names[::2], change.names[1::2], strict=True)
    ]
    suffix = f" and {len(pairs) - 4} more" if len(pairs) > 4 else ""
    mend = "joint angles and positions of different poses are combined: use the same order of rows or files"
    return "the order of the poses", f"the poses in another order ({', '.join(pairs[:4])}{suffix})", mend


def _row_order(change: InputChange, chain: Chain) -> _Texts:
    (moved,) = change.names
    if not change.sizes:
        return (
            "the order of the rows",
            f"the order of the {moved} reversed",
            f"reverse the rows of the {moved} against those of the other columns",
        )
    (size,) = change.sizes
    rows = "one row" if abs(size) == 1.0 else f"{abs(size):.0f} rows"
    by = f"{'down' if size > 0.0 else 'up'} by {rows}"
    mend = f"move the columns of the {moved} {by} against the other columns"
    return "the order of the rows", f"all {moved} moved {by}", mend


def _robot_convention(change: InputChange, chain: Chain) -> _Texts:
    line = toml_text.pair("convention", change.value)
    return "convention", line, f"write {line} in the robot file"


def _robot_sign(change: InputChange, chain: Chain) -> _Texts:
    (name,), (value,) = change.names, change.sizes
    place = f"joints[{chain.joint_names.index(name) + 1}] ({name}).{change.value}"
    mend = f"change the sign of {change.value} of joint {name}"
    return place, f"{change.value} = {value:g} of joint {name}", mend


def _acts_on(change: InputChange, chain: Chain) -> _Texts:
    line = toml_text.pair("acts_on", change.value)
    return "wrench", f"the load on the {change.value}", f"acts_on is inverted: write {line}"


def _sensor_axes(change: InputChange, chain: Chain) -> _Texts:
    (axis,) = change.names
    mend = f"the sensor is upside down, half a turn about {axis} of its axes: correct its frame"
    return "wrench", f"the sensor turned by 180° about its {axis}", mend


def _wrench_columns(change: InputChange, chain: Chain) -> _Texts:
    mend = f"columns are interchanged, here or in the log: write {toml_text.pair('columns', list(change.names))}"
    if change.value == FORCES_ALONE:
        mend += ", and check whether the moments are in this order"
    return "wrench.columns", "the force's columns in another order", mend


def _wrench_sign(change: InputChange, chain: Chain) -> _Texts:
    (name,) = change.names
    return f"column {name}", f"column {name} with the other sign", "correct its sign in the log"


def _displacement_axes(change: InputChange, chain: Chain) -> _Texts:
    words = f"the axes of the displacements as ({', '.join(change.names)})"
    return "displacements", words, "correct the order and the signs of their columns, or their axes"


def _quaternion_order(change: InputChange, chain: Chain) -> _Texts:
    return "quaternion_wxyz", "the quaternion x, y, z, w", "write the quaternion's columns with w first"


def _quaternion_inverse(change: InputChange, chain: Chain) -> _Texts:
    return "quaternion_wxyz", "the quaternion inverted", "invert the orientation"


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them.

    Examples
    --------
    >>> listed(["A", "B", "C"])
    'A, B and C'
    """
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def _millimetres(lengths: Sequence[float]) -> str:
    return ", ".join(f"{1e3 * part:.1f}" for part in lengths)


_TEXTS: dict[ChangeKind, Callable[[InputChange, Chain], _Texts]] = {
    ChangeKind.ANGLE_UNIT: _angle_unit,
    ChangeKind.LENGTH_UNIT: _length_unit,
    ChangeKind.LENGTH_FACTOR: _length_factor,
    ChangeKind.TARGET_ORDER: _target_order,
    ChangeKind.POSITION_AXES: _position_axes,
    ChangeKind.MIRRORED: _mirrored,
    ChangeKind.ROBOT_CONVENTION: _robot_convention,
    ChangeKind.ROBOT_SIGN: _robot_sign,
    ChangeKind.JOINT_UNIT: _joint_unit,
    ChangeKind.JOINT_ORDER: _joint_order,
    ChangeKind.DIRECTION: _direction,
    ChangeKind.COUNTED_TOGETHER: _counted_together,
    ChangeKind.ZERO: _zeros,
    ChangeKind.TRACKER_FRAME: _tracker_frame,
    ChangeKind.TRACKER_AXES: _tracker_axes,
    ChangeKind.INVERSE_FRAME: _inverse_frame,
    ChangeKind.TARGET: _target,
    ChangeKind.POSE_ORDER: _pose_order,
    ChangeKind.ROW_ORDER: _row_order,
    ChangeKind.QUATERNION_ORDER: _quaternion_order,
    ChangeKind.QUATERNION_INVERSE: _quaternion_inverse,
    ChangeKind.ACTS_ON: _acts_on,
    ChangeKind.SENSOR_AXES: _sensor_axes,
    ChangeKind.WRENCH_COLUMNS: _wrench_columns,
    ChangeKind.WRENCH_SIGN: _wrench_sign,
    ChangeKind.DISPLACEMENT_AXES: _displacement_axes,
}
