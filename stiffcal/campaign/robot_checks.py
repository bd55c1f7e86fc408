"""What is wrong with a robot file as a whole, and what its joints and links are called; needs no numpy."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.naming import beam_name, name_links
from stiffcal.campaign.reach import escapes
from stiffcal.campaign.robot_file import JointEntry, RobotFile
from stiffcal.campaign.sizes import implausible_length
from stiffcal.campaign.urdf import read_urdf
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode

NEARLY_PARALLEL = math.sin(math.radians(5.0))
"""Sine of the angle between two axes below which the rows' d may lie far away."""
# Sine of an angle that only rounding of 0° or 180° makes.
_EXACTLY_PARALLEL = 1e-12
_ROW_KEYS = ("a_m", "alpha_deg", "beta_deg", "d_m")


@dataclass(frozen=True)
class RobotOutline:
    """A robot's names."""

    joint_names: tuple[str, ...]
    """J names."""
    link_names: tuple[str, ...]
    """All names that its links go by, `swing` and `arm` included."""


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
        turning = read_urdf(path.parent / robot.urdf, robot.urdf, robot.base_link, robot.tip_link).turning
        joints = tuple(joint.name for joint in turning)
        links = name_links([written.get(joint.name) or joint.child for joint in turning])
        unknown = [name for name in written if name not in joints]
        if unknown:
            reason = f'the URDF has no revolute joint "{unknown[0]}"'
            raise InputError.at(
                FaultCode.JOINT_UNKNOWN, path.name, f"joints ({unknown[0]})", reason, "use " + ", ".join(joints)
            )
    else:
        joints = tuple(entry.name for entry in robot.joints)
        links = name_links([entry.link.name for entry in robot.joints])
    beams = tuple(beam_name(k, links) for k in range(len(links)))
    return RobotOutline(joints, tuple(dict.fromkeys((*links, *beams))))


def robot_faults(robot: RobotFile, file: str) -> list[Fault]:
    """Check a robot file in itself."""
    return list(_faults(robot, file))


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
    if entry.limits_deg is not None and entry.limits_deg[0] >= entry.limits_deg[1]:
        low, high = entry.limits_deg
        yield Fault(
            FaultCode.VALUE_INVALID,
            file,
            f"{place}.limits_deg",
            f"the lower limit {low} is not below {high}",
            "write [low, high]",
        )
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
