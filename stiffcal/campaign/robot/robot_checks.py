"""What is wrong with a robot file as a whole, and what its joints and links are called; needs no numpy."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.robot.robot_file import JointEntry, RobotFile
from stiffcal.campaign.robot.sizes import implausible_length
from stiffcal.campaign.robot.urdf.chain import PRISMATIC, read_urdf
from stiffcal.campaign.robot.urdf.elements import UrdfJoint
from stiffcal.campaign.toml.naming import beam_name, name_links
from stiffcal.campaign.toml.reach import escapes
from stiffcal.campaign.toml.typed import Placement
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode

NEARLY_PARALLEL = math.sin(math.radians(5.0))
"""Sine of the angle between two axes below which the rows' d may lie far away."""
# Sine of an angle that only rounding of 0° or 180° makes.
_EXACTLY_PARALLEL = 1e-12
_LIMITS_IN_URDF = "<limit lower=… upper=…/> to the joint in the URDF, or in robot.toml "
_NO_ROWS = "a_m, alpha_deg and d_m are zero at every joint: the file holds no geometry"
_WRITE_ROWS = (
    "write each joint's row, copy another campaign's robot.toml over it, or repeat stiffcal init in a new folder with "
    "--robot NAME or --urdf FILE"
)
_ROW_KEYS = ("a_m", "alpha_deg", "beta_deg", "d_m", "type")


@dataclass(frozen=True)
class RobotOutline:
    """A robot's names."""

    joint_names: tuple[str, ...]
    """J names."""
    link_names: tuple[str, ...]
    """All names that its links go by, `swing` and `arm` included."""
    prismatic: frozenset[str] = frozenset()
    """Names of the joints that move along their axis."""


def outline_of(robot: RobotFile, path: Path) -> RobotOutline:
    """Return a robot's names, from its file or its URDF.

    Parameters
    ----------
    robot : the robot file.
    path : where it lies; a URDF's path counts from its folder.

    Raises
    ------
    InputError
        The URDF cannot be read.
    """
    written = {entry.name: entry.link.name for entry in robot.joints}
    if robot.urdf is not None:
        moving = read_urdf(path.parent / robot.urdf, robot.urdf, robot.base_link, robot.tip_link).moving
        joints = tuple(joint.name for joint in moving)
        prismatic = frozenset(joint.name for joint in moving if joint.kind == PRISMATIC)
        raise_faults(list(_kinds_in_urdf(robot, moving, prismatic, path.name)))
        links = name_links([written.get(joint.name) or joint.child for joint in moving])
        unknown = [name for name in written if name not in joints]
        if unknown:
            reason = f'the URDF has no moving joint "{unknown[0]}"'
            raise InputError.at(
                FaultCode.JOINT_UNKNOWN, path.name, f"joints ({unknown[0]})", reason, "use " + ", ".join(joints)
            )
    else:
        joints = tuple(entry.name for entry in robot.joints)
        links = name_links([entry.link.name for entry in robot.joints])
        prismatic = frozenset(entry.name for entry in robot.joints if entry.type == PRISMATIC)
    beams = tuple(beam_name(k, links) for k in range(len(links)))
    return RobotOutline(joints, tuple(dict.fromkeys((*links, *beams))), prismatic)


def _kinds_in_urdf(
    robot: RobotFile, moving: Sequence[UrdfJoint], prismatic: frozenset[str], file: str
) -> Iterator[Fault]:
    """Yield what of the robot file contradicts the kinds of the URDF's joints."""
    written = {entry.name: entry for entry in robot.joints}
    for joint in moving:
        entry = written.get(joint.name, JointEntry(name=joint.name))
        if joint.limits is not None and entry.limits_m is None and joint.name in prismatic:
            entry = entry.model_copy(update={"limits_m": joint.limits})
        yield from _kind_faults(entry, prismatic, file, f"joints ({joint.name})", _LIMITS_IN_URDF)
    if robot.gravity_compensator is not None:
        names = [joint.name for joint in moving]
        yield from _compensator_faults(robot.gravity_compensator.joint, names, prismatic, file)


def robot_faults(robot: RobotFile, file: str) -> list[Fault]:
    """Check a robot file in itself."""
    return list(_faults(robot, file))


def unfilled_faults(robot: RobotFile, file: str) -> list[Fault]:
    """Return a fault where no joint's row holds a length or an angle: all axes would coincide.

    A bench may leave them out where it measures torques of joints alone; who compares places or displacements may not.
    """
    revolute = [entry for entry in robot.joints if entry.type != PRISMATIC]
    if len(revolute) < 2 or not holds_no_rows(robot):
        return []
    return [Fault(FaultCode.VALUE_INVALID, file, "joints", _NO_ROWS, _WRITE_ROWS)]


def weight_faults(robot: RobotFile, file: str, run: str, steady: bool = False) -> list[Fault]:
    """Return a fault where weight and inertia of a run's motion cannot be modelled: no joint's row holds anything.

    One axis on a bench needs none where the file states that no weight acts, or where it goes at constant velocity.

    Parameters
    ----------
    robot : the robot file. file : its name. run : a run in which weight and inertia are part of what is measured.
    steady : whether the joints of the run go at constant velocity, so that inertia is no part of it.
    """
    several = len([entry for entry in robot.joints if entry.type != PRISMATIC]) > 1
    weighs = any(robot.gravity_mps2)
    # a base that is turned gives one axis its direction against gravity
    unplaced = weighs and robot.base == Placement()
    if not holds_no_rows(robot) or not ((several and weighs) if steady else (several or unplaced)):
        return []
    acting = "weight" if steady else "weight and inertia"
    reason = f"{_NO_ROWS}, without which {acting} in run {run} cannot be modelled"
    no_weight = "; where no weight acts, as on a bench, write gravity_mps2 = [0, 0, 0]"
    bench = "" if several and not steady else no_weight
    return [Fault(FaultCode.VALUE_INVALID, file, "joints", reason, _WRITE_ROWS + bench)]


def holds_no_rows(robot: RobotFile) -> bool:
    """Return whether no row of the file holds a length or an angle; False of a URDF."""
    rows = [(entry.a_m, entry.alpha_deg, entry.beta_deg, entry.d_m) for entry in robot.joints]
    return robot.urdf is None and bool(rows) and not any(value != 0.0 for row in rows for value in row)


def _faults(robot: RobotFile, file: str) -> Iterator[Fault]:
    if (robot.urdf is None) == (robot.convention is None):
        reason = "neither convention nor urdf is given" if robot.urdf is None else "both convention and urdf are given"
        yield Fault(
            FaultCode.KEY_CONFLICT,
            file,
            "convention",
            reason,
            'write convention = "modified-dh" or "dh", or urdf = "robot.urdf"',
        )
    if robot.urdf is None and not robot.joints:
        yield Fault(
            FaultCode.KEY_MISSING,
            file,
            "joints",
            "the robot has no joints",
            "add one [[joints]] per joint, base to wrist",
        )
    if robot.urdf is not None and escapes(robot.urdf):
        yield Fault(
            FaultCode.FILE_OUTSIDE,
            file,
            "urdf",
            f'"{robot.urdf}" lies outside the campaign folder',
            "use a file inside the folder",
        )
    for key, placement in (("base", robot.base), ("flange", robot.flange)):
        mistake = placement.rotation_mistake()
        if mistake is not None:
            yield Fault(FaultCode.VALUE_INVALID, file, f"{key}.{mistake[0]}", mistake[1].reason, mistake[1].mend)
        for metres in placement.xyz_m:
            too_long = implausible_length(metres)
            if too_long is not None:
                yield Fault(FaultCode.VALUE_INVALID, file, f"{key}.xyz_m", too_long.reason, too_long.mend)
    if robot.urdf is not None and "base" in robot.model_fields_set:
        yield Fault(FaultCode.KEY_CONFLICT, file, "base", "the URDF already contains the geometry", "remove [base]")
    yield from _long_rows(robot, file)
    names = [entry.name for entry in robot.joints]
    for name, count in Counter(names).items():
        if count > 1:
            yield Fault(
                FaultCode.NAME_DUPLICATE,
                file,
                f"joints ({name})",
                f'{count} joints have the name "{name}"',
                "give each a unique name",
            )
    links = Counter(entry.link.name for entry in robot.joints if entry.link.name is not None)
    for name, count in links.items():
        if count > 1:
            yield Fault(
                FaultCode.NAME_DUPLICATE,
                file,
                "joints.link.name",
                f'{count} links have the name "{name}"',
                "give each a unique name",
            )
    if robot.urdf is None:
        prismatic = frozenset(entry.name for entry in robot.joints if entry.type == PRISMATIC)
        for number, entry in enumerate(robot.joints):
            yield from _kind_faults(entry, prismatic, file, f"joints[{number + 1}] ({entry.name})")
        if robot.gravity_compensator is not None:
            yield from _compensator_faults(robot.gravity_compensator.joint, names, prismatic, file)
    for number, entry in enumerate(robot.joints):
        yield from _joint_faults(robot, entry, names, file, f"joints[{number + 1}] ({entry.name})")
    compensator = robot.gravity_compensator
    if compensator is not None and robot.urdf is None and compensator.joint > len(robot.joints):
        reason = f"joint {compensator.joint}, but the robot has {len(robot.joints)} joints"
        yield Fault(FaultCode.JOINT_UNKNOWN, file, "gravity_compensator.joint", reason, "count the joints from 1")
    if robot.urdf is None:
        known = name_links([entry.link.name for entry in robot.joints])
        places = {*known, *(beam_name(k, known) for k in range(len(known)))}
        for name in robot.links:
            if name not in places:
                yield Fault(
                    FaultCode.LINK_UNKNOWN,
                    file,
                    f"links.{name}",
                    f'there is no link "{name}"',
                    "use " + ", ".join(known),
                )


def _long_rows(robot: RobotFile, file: str) -> Iterator[Fault]:
    """Yield a fault for each d that is longer than any robot, unless nearly parallel axes put it there.

    Of these the common normal lies far away, and the next joint's d leads back. Exactly parallel axes have it anywhere,
    and a d that is written there is in another unit.
    """
    between = robot.joints[:-1] if robot.convention == "dh" else robot.joints[1:]
    inclined = [abs(math.sin(math.radians(entry.alpha_deg))) for entry in between]
    parallel = [_EXACTLY_PARALLEL < sine < NEARLY_PARALLEL for sine in inclined]
    for k, entry in enumerate(robot.joints):
        mistake = implausible_length(entry.d_m)
        if mistake is not None and not any(parallel[max(0, k - 1) : k + 1]):
            place = f"joints[{k + 1}] ({entry.name}).d_m"
            yield Fault(FaultCode.VALUE_INVALID, file, place, mistake.reason, mistake.mend)


def _compensator_faults(joint: int, names: Sequence[str], prismatic: frozenset[str], file: str) -> Iterator[Fault]:
    if joint <= len(names) and names[joint - 1] in prismatic:
        reason = f"{names[joint - 1]} is prismatic, and the spring turns a joint"
        yield Fault(FaultCode.VALUE_INVALID, file, "gravity_compensator.joint", reason, "name a revolute joint")


def _kind_faults(
    entry: JointEntry, prismatic: frozenset[str], file: str, place: str, in_urdf: str = ""
) -> Iterator[Fault]:
    """Yield what contradicts the kind of a joint; ``prismatic``: names of the joints that move along their axis."""
    own = entry.name in prismatic
    if own and entry.limits_m is None:
        reason = "a prismatic joint has two ends, and none are given"
        yield Fault(
            FaultCode.KEY_MISSING, file, f"{place}.limits_m", reason, f"add {in_urdf}limits_m = [0.0, 1.2], say, in m"
        )
    for key, wrong in (("limits_deg", own), ("gear_orders", own), ("limits_m", not own)):
        if wrong and key in entry.model_fields_set:
            reason = f"{entry.name} is {'prismatic: it has no angle' if own else 'revolute'}"
            mend = "write limits_m" if key == "limits_deg" else 'remove it, or write type = "prismatic"'
            yield Fault(
                FaultCode.KEY_CONFLICT,
                file,
                f"{place}.{key}",
                reason,
                f"remove {key}" if own and key == "gear_orders" else mend,
            )
    for name in entry.logged or {}:
        if (name in prismatic) != own:
            reason = f"{entry.name} and {name} are not of one kind: an angle and a length have no sum"
            yield Fault(FaultCode.KEY_CONFLICT, file, f"{place}.logged.{name}", reason, f"remove {name}")


def _joint_faults(robot: RobotFile, entry: JointEntry, names: list[str], file: str, place: str) -> Iterator[Fault]:
    if robot.urdf is not None:
        for key in _ROW_KEYS:
            if key in entry.model_fields_set:
                yield Fault(
                    FaultCode.KEY_CONFLICT,
                    file,
                    f"{place}.{key}",
                    "the URDF already contains the geometry",
                    f"remove {key}",
                )
    for name in entry.logged or {}:
        if robot.urdf is None and name not in names:
            yield Fault(
                FaultCode.JOINT_UNKNOWN,
                file,
                f"{place}.logged.{name}",
                f'there is no joint "{name}"',
                "use " + ", ".join(names),
            )
    if entry.logged is not None and not any(entry.logged.values()):
        yield Fault(
            FaultCode.VALUE_INVALID,
            file,
            f"{place}.logged",
            "all coefficients are zero",
            "write coefficients other than zero",
        )
    if entry.gear_ratio == 0.0:
        yield Fault(
            FaultCode.VALUE_INVALID,
            file,
            f"{place}.gear_ratio",
            "a gear ratio of zero",
            "write motor side / joint side",
        )
    for key, limits in (("limits_deg", entry.limits_deg), ("limits_m", entry.limits_m)):
        if limits is not None and limits[0] >= limits[1]:
            reason = f"the lower limit {limits[0]} is not below {limits[1]}"
            yield Fault(FaultCode.VALUE_INVALID, file, f"{place}.{key}", reason, "write [low, high]")
    for metres in entry.limits_m or ():
        mistake = implausible_length(metres)
        if mistake is not None:
            yield Fault(FaultCode.VALUE_INVALID, file, f"{place}.limits_m", mistake.reason, mistake.mend)
    if (entry.link.com_m is not None) and entry.link.mass_kg is None:
        yield Fault(FaultCode.KEY_MISSING, file, f"{place}.link", "a centre of mass without a mass", "add mass_kg")
    if entry.link.mass_kg and entry.link.com_m is None:
        yield Fault(
            FaultCode.KEY_MISSING,
            file,
            f"{place}.link",
            "a mass without its centre",
            "add com_m, in the joint's own frame",
        )
