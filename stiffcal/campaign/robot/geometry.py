"""From a robot file to the chain: DH, modified DH and URDF to one set of joint frames.

The frame of joint k moves with link k and has its z axis along the joint's axis. Its origin is where the convention
puts it: modified DH, frame k itself (Craig, Introduction to Robotics, 3rd ed., eq. 3.6); DH, frame k-1 turned about its
z; URDF, the joint's frame turned by the shortest rotation that takes z to the axis. Rows may have Hayati's β, a turn
about y after a and α (`stiffcal.mechanics.joint_rows`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.beams import link_beams
from stiffcal.campaign.robot.robot_file import ANGLE_SIGMA_DEG, LENGTH_SIGMA_M, GeometryEntry, JointEntry, RobotFile
from stiffcal.campaign.robot.transforms import (
    placement_matrix,
    rotation_taking_z_to,
    screw_x,
    translation,
    turned_about_z,
)
from stiffcal.campaign.robot.urdf.chain import PRISMATIC, UrdfRobot, read_urdf
from stiffcal.campaign.robot.urdf.elements import UrdfJoint
from stiffcal.campaign.robot.urdf.riders import joint_origin, riding_links
from stiffcal.campaign.toml.naming import name_links
from stiffcal.campaign.toml.typed import Placement
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain, GeometryTolerance
from stiffcal.mechanics.joint_rows import JointRows, RowsOfChain, rows_as_planned
from stiffcal.mechanics.rotations import rotation_from_rpy


@dataclass(frozen=True)
class _Skeleton:
    """What the convention decides: frames, names and, for a URDF, masses and limits."""

    fixed: Floats
    """(J, 4, 4)."""
    flange: Floats
    """(4, 4), before the robot file's own flange."""
    entries: tuple[JointEntry, ...]
    """J entries of the robot file, defaults where it has none."""
    link_names: tuple[str | None, ...]
    """J names."""
    mass: Floats
    """(J,) kg, NaN where not known."""
    com: Floats
    """(J, 3) m."""
    limits: Floats
    """(J, 2) of the model angle, rad, or position, m."""
    prismatic: tuple[bool, ...]
    """J, True where the joint moves along its axis."""


def chain_of(robot: RobotFile, folder: Path) -> Chain:
    """Build the chain that the physics uses.

    Parameters
    ----------
    robot : the robot file.
    folder : where the robot file lies; a URDF's path counts from there.

    Raises
    ------
    InputError
        The URDF cannot be read, or has no such joint or link.

    Examples
    --------
    >>> row = {"name": "A1", "d_m": 0.5}
    >>> robot = RobotFile.model_validate({"schema": "stiffcal/robot/1", "convention": "dh", "joints": [row]})
    >>> chain_of(robot, Path(".")).flange[:3, 3].tolist()
    [0.0, 0.0, 0.5]
    """
    skeleton = _from_urdf(robot, folder) if robot.urdf is not None else _from_rows(robot)
    entries = skeleton.entries
    coupling = _coupling(entries)
    # of a prismatic joint θ is a turn of its frame, which lies in the fixed part
    turn = np.deg2rad([entry.theta_deg for entry in entries])
    offset = np.where(skeleton.prismatic, 0.0, turn)
    fixed = np.array(
        [
            step @ turned_about_z(angle) if prismatic and angle else step
            for step, angle, prismatic in zip(skeleton.fixed, turn, skeleton.prismatic, strict=True)
        ]
    )
    bearing = np.array([entry.bearing_m for entry in entries])
    link_names = name_links([entry.link.name or name for entry, name in zip(entries, skeleton.link_names, strict=True)])
    mass, com = _masses(skeleton)
    masses_known = bool(np.isfinite(mass).all())
    return Chain(
        name=robot.name or "robot",
        joint_names=tuple(entry.name for entry in entries),
        fixed=fixed,
        flange=skeleton.flange @ placement_matrix(robot.flange),
        coupling=coupling,
        offset=offset,
        limits=_limits(skeleton, coupling, offset),
        gear_ratio=np.array([entry.gear_ratio for entry in entries]),
        gear_orders=tuple(entry.gear_orders for entry in entries),
        mechanical=np.array([entry.coupling == "mechanical" for entry in entries]),
        bearing=bearing,
        link_names=link_names,
        link_mass=np.where(np.isfinite(mass), mass, 0.0),
        link_com=com,
        masses_known=masses_known,
        gravity=np.array(robot.gravity_mps2),
        rated_payload=robot.rated_payload_kg,
        beams=link_beams(robot, fixed, bearing, link_names, skeleton.prismatic),
        compensator=None if robot.gravity_compensator is None else robot.gravity_compensator.model_dump(),
        tolerance=_tolerance(robot.geometry),
        prismatic_joints=frozenset(k + 1 for k, prismatic in enumerate(skeleton.prismatic) if prismatic),
    )


def _tolerance(stated: GeometryEntry) -> GeometryTolerance:
    length, angle = stated.length_sigma_m, stated.angle_sigma_deg
    return GeometryTolerance(
        LENGTH_SIGMA_M if length is None else length,
        float(np.radians(ANGLE_SIGMA_DEG if angle is None else angle)),
        stated=length is not None or angle is not None,
    )


def _from_rows(robot: RobotFile) -> _Skeleton:
    """Take the joint frames from DH or modified DH rows."""
    entries = robot.joints
    screws = [_crossing(entry) for entry in entries]
    lifts = [translation((0.0, 0.0, entry.d_m)) for entry in entries]
    if robot.convention == "modified-dh":
        fixed = [screw @ lift for screw, lift in zip(screws, lifts, strict=True)]
        flange = np.eye(4)
    else:
        steps = [lift @ screw for screw, lift in zip(screws, lifts, strict=True)]
        fixed, flange = [np.eye(4), *steps[:-1]], steps[-1]
    if robot.base != Placement():
        fixed[0] = placement_matrix(robot.base) @ fixed[0]
    count = len(entries)
    return _Skeleton(
        np.array(fixed),
        flange,
        entries,
        (None,) * count,
        np.full(count, np.nan),
        np.zeros((count, 3)),
        np.tile([-np.inf, np.inf], (count, 1)),
        tuple(entry.type == PRISMATIC for entry in entries),
    )


def _crossing(entry: JointEntry) -> Floats:
    """Return Rx(α) · Tx(a) · Ry(β) of a row."""
    screw = screw_x(entry.a_m, np.deg2rad(entry.alpha_deg))
    if entry.beta_deg:
        screw[:3, :3] = screw[:3, :3] @ rotation_from_rpy(np.array([0.0, np.deg2rad(entry.beta_deg), 0.0]))
    return screw


def planned_rows(robot: RobotFile, chain: Chain) -> RowsOfChain:
    """Return the robot's geometry as rows: those of its file, or for a URDF rows of modified DH.

    Parameters
    ----------
    robot : the robot file. chain : as `chain_of` builds it.
    """
    if robot.convention is None:
        return rows_as_planned(chain, "modified-dh")
    entries = robot.joints
    degrees = np.deg2rad([[entry.alpha_deg, entry.beta_deg, entry.theta_deg] for entry in entries]).T
    return RowsOfChain.own(
        JointRows(
            robot.convention,
            np.array([entry.a_m for entry in entries]),
            degrees[0],
            degrees[1],
            np.array([entry.d_m for entry in entries]),
            degrees[2],
            placement_matrix(robot.base),
            placement_matrix(robot.flange),
        )
    )


def _from_urdf(robot: RobotFile, folder: Path) -> _Skeleton:
    """Take the joint frames, masses and limits from a URDF."""
    file = str(robot.urdf)
    urdf = read_urdf(folder / file, file, robot.base_link, robot.tip_link)
    moving = urdf.moving
    fixed, limits = [], []
    before = np.eye(4)  # last joint frame to the link reached so far
    for joint in urdf.path:
        before = before @ joint_origin(joint)
        if joint.kind != "fixed":
            turn = rotation_taking_z_to(joint.axis)
            fixed.append(before @ turn)
            limits.append(joint.limits or (-np.inf, np.inf))
            before = turn.T  # the joint's own frame expressed in the turned one: a rotation, so the transpose
    masses = [_combine_masses(urdf, joint) for joint in moving]
    return _Skeleton(
        np.array(fixed),
        before,
        _urdf_entries(robot, moving),
        tuple(joint.child for joint in moving),
        np.array([mass for mass, _ in masses]),
        np.array([com for _, com in masses]),
        np.array(limits),
        tuple(joint.kind == PRISMATIC for joint in moving),
    )


def _urdf_entries(robot: RobotFile, moving: tuple[UrdfJoint, ...]) -> tuple[JointEntry, ...]:
    """Put the robot file's entries to the URDF's joints, by name."""
    written = {entry.name: entry for entry in robot.joints}
    names = [joint.name for joint in moving]
    for name in written:
        if name not in names:
            raise InputError.at(
                FaultCode.JOINT_UNKNOWN,
                "robot.toml",
                f"joints ({name})",
                f'the URDF has no moving joint "{name}"',
                "use " + ", ".join(names),
            )
    return tuple(written.get(name, JointEntry(name=name)) for name in names)


def _combine_masses(urdf: UrdfRobot, joint: UrdfJoint) -> tuple[float, Floats]:
    """Sum the masses that ride on a joint up to the next of the chain: (kg, com in the joint frame, m).

    Mass is NaN where no link of it has an inertial.
    """
    total, moment, has_mass = 0.0, np.zeros(3), False
    for link, place in riding_links(urdf, joint):
        if link.mass is not None:
            has_mass = True
            total += link.mass
            moment = moment + link.mass * (place @ np.array([*link.com, 1.0]))[:3]
    if not has_mass:
        return np.nan, np.zeros(3)
    return total, moment / total if total > 0 else np.zeros(3)


def _coupling(entries: tuple[JointEntry, ...]) -> Floats:
    """Write ``direction`` and ``logged`` as one matrix (J, L): model angle = matrix @ logged + offset."""
    names = [entry.name for entry in entries]
    matrix = np.zeros((len(entries), len(entries)))
    for row, entry in enumerate(entries):
        for name, coefficient in (entry.logged or {entry.name: 1.0}).items():
            matrix[row, names.index(name)] = entry.direction * coefficient
    return matrix


def _limits(skeleton: _Skeleton, coupling: Floats, offset: Floats) -> Floats:
    """Return limits of the logged angles (J, 2), rad and m; a URDF's count for the model angle and are turned back."""
    limits = np.tile([-np.inf, np.inf], (len(skeleton.entries), 1))
    for k, entry in enumerate(skeleton.entries):
        if entry.limits_m is not None:
            limits[k] = entry.limits_m
        elif entry.limits_deg is not None:
            limits[k] = np.deg2rad(entry.limits_deg)
        elif np.count_nonzero(coupling[k]) == 1 and coupling[k, k] != 0.0:
            limits[k] = np.sort((skeleton.limits[k] - offset[k]) / coupling[k, k])
    return limits


def _masses(skeleton: _Skeleton) -> tuple[Floats, Floats]:
    """Prefer the robot file's masses to the URDF's: (J,) with NaN where neither gives one, (J, 3)."""
    mass, com = skeleton.mass.copy(), skeleton.com.copy()
    for k, entry in enumerate(skeleton.entries):
        if entry.link.mass_kg is not None:
            mass[k] = entry.link.mass_kg
        if entry.link.com_m is not None:
            com[k] = entry.link.com_m
    return mass, com
