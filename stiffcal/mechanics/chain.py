"""The robot as a chain of bodies: geometry and masses, as arrays.

The frame of joint k (k = 1 … J) moves with link k, has its z axis along the joint's axis and its origin where the robot
file's convention puts it. ``frame_k = frame_(k-1) @ fixed[k-1] @ Rz(q_k)``, frame 0 being the base; for a prismatic
joint Tz(q_k) in place of Rz(q_k). Arrays of joint angles hold a prismatic joint's position in m. Where poses are
compared, 1 m counts as 1 rad: what lies a metre from an axis moves by as much, and 1° is 17.5 mm.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.rods import BeamProperties
from stiffcal.mechanics.section import BeamSection
from stiffcal.quantity import LENGTH


@dataclass(frozen=True)
class BeamFrame:
    """Where a link bends: its beam frame in the link's joint frame."""

    joint: int
    """k = 1 … J, the joint that moves this link."""
    end: Floats
    """(4, 4) joint_frame_from_beam_frame at the beam's *outboard* end; x1 along the beam, x3 the inboard joint's axis
    made perpendicular to x1 (x1 parallel to it: the outboard axis), x2 = x3 × x1.
    """
    length: float
    """m."""
    warping_decay: float | None = None
    """m, as the robot file gives it, or None."""
    section: BeamSection | None = None
    """The drawn section, solved, or None; solved only where somebody needs it (rods on the link)."""
    expansion: float | None = None
    """1/K, thermal, as the robot file gives it, or None."""

    @property
    def shape(self) -> BeamProperties:
        """What the displacement field of the link needs to know: the drawn section's fibres and decay, if drawn."""
        section = self.section
        if section is None:
            return BeamProperties(self.length, warping_decay=self.warping_decay)
        decay = self.warping_decay if self.warping_decay is not None else section.warping_decay
        return BeamProperties(self.length, section.neutral, section.twist_centre, decay, section.warping_hold)


@dataclass(frozen=True)
class GeometryTolerance:
    """Standard deviations of the chain's lengths and angles about those of the robot file."""

    length: float = 0.0
    """m, of every shift between joint frames along one axis."""
    angle: float = 0.0
    """rad, of every turn between joint frames about one axis."""
    stated: bool = True
    """False for the default: what absolute places show is then better."""


@dataclass(frozen=True)
class Chain:
    """Geometry and masses of a serial robot with J revolute or prismatic joints, of which L angles are logged."""

    name: str
    """The robot's name."""
    joint_names: tuple[str, ...]
    """J names."""
    fixed: Floats
    """(J, 4, 4) from frame k-1 to frame k at q_k = 0, m."""
    flange: Floats
    """(4, 4) last joint frame to flange, m."""
    coupling: Floats
    """(J, L) model angle = coupling @ logged + offset; carries ``direction`` and ``logged``."""
    offset: Floats
    """(J,) rad, ``theta_deg``; 0 of a prismatic joint, whose θ is in ``fixed``."""
    limits: Floats
    """(J, 2) rad, of the logged angles, m of a prismatic joint; infinite where not given."""
    gear_ratio: Floats
    """(J,) motor side / joint side."""
    gear_orders: tuple[tuple[int, ...], ...]
    """J tuples of orders per joint turn."""
    mechanical: NDArray[np.bool_]
    """(J,) True where ``coupling = "mechanical"``: the drives sit on the logged axes, so springs act there."""
    bearing: Floats
    """(J,) m along the joint's axis from the frame's origin to the bearing."""
    link_names: tuple[str, ...]
    """J names."""
    link_mass: Floats
    """(J,) kg, zero where not known; see ``masses_known``."""
    link_com: Floats
    """(J, 3) m, in the link's joint frame."""
    masses_known: bool
    """True where the robot file gives every link a mass."""
    gravity: Floats
    """(3,) m/s² in base axes."""
    rated_payload: float | None = None
    """kg at the flange that the maker allows; None where the robot file does not state it."""
    beams: dict[str, BeamFrame] = field(default_factory=dict)
    """Link name to its beam."""
    compensator: dict[str, object] | None = None
    """Gravity compensator's geometry as in the robot file, or None."""
    tolerance: GeometryTolerance = GeometryTolerance()
    """How well ``fixed`` is known; exact where nothing is stated (a robot file always states or takes the default)."""
    prismatic_joints: frozenset[int] = frozenset()
    """Joints, from 1, that move along their axis instead of turning about it."""

    @property
    def largest_payload(self) -> float:
        """Kilograms at the flange beyond which no load is worth proposing; infinite where nothing limits it.

        Where the maker's payload is not stated: no arm of this kind carries more than it weighs.
        """
        if self.rated_payload is not None:
            return self.rated_payload
        return float(np.sum(self.link_mass)) if self.masses_known else np.inf

    @property
    def n_joints(self) -> int:
        """J, the number of joints."""
        return int(self.fixed.shape[0])

    @cached_property
    def prismatic(self) -> Booleans:
        """(J,) True where the joint moves along its axis."""
        return np.array([k + 1 in self.prismatic_joints for k in range(self.n_joints)], dtype=np.bool_)

    @cached_property
    def drive_components(self) -> Integers:
        """(J,) the component of the joint's node that its drive moves: 5, the turn about z, or 2, the shift along z."""
        return np.where(self.prismatic, 2, 5)

    @property
    def prismatic_names(self) -> frozenset[str]:
        """Names of the prismatic joints."""
        return frozenset(self.joint_names[joint - 1] for joint in self.prismatic_joints)

    @property
    def position_units(self) -> tuple[str, ...]:
        """J units in which joint positions are read and printed: "deg", or "mm" of a prismatic joint."""
        return tuple(LENGTH.usual.name if prismatic else "deg" for prismatic in self.prismatic)

    def printed_positions(self, joints: Floats) -> Floats:
        """Turn joint positions (…, J), rad and m, into degrees and mm."""
        return np.where(self.prismatic, LENGTH.usual.factor * np.asarray(joints), np.degrees(joints))

    def position_words(self, joints: Floats, form: str = ".4g") -> str:
        """Return joint positions (J,), rad and m, in words: degrees, and mm of prismatic joints."""
        positions = zip(self.printed_positions(joints), self.prismatic, strict=True)
        return ", ".join(f"{value:{form}}{' mm' if prismatic else '°'}" for value, prismatic in positions)

    def from_printed(self, positions: Floats) -> Floats:
        """Turn joint positions (…, J), degrees and mm, into rad and m."""
        return np.where(self.prismatic, np.asarray(positions) / LENGTH.usual.factor, np.radians(positions))

    @property
    def joint_of_link(self) -> dict[str, int]:
        """Each link's name as a place of effects (in ``beams``, its name there) to the joint, from 1, that moves it."""
        bending = {beam.joint: name for name, beam in self.beams.items()}
        return {bending.get(k + 1, name): k + 1 for k, name in enumerate(self.link_names)}

    def model_angles(self, logged: Floats) -> Floats:
        """Turn logged joint angles (n, L), rad, into the chain's own (n, J), rad."""
        return np.asarray(logged @ self.coupling.T + self.offset, dtype=np.float64)

    @cached_property
    def drive_axes(self) -> Floats:
        """(J, J) by how much each model joint (row) turns when each drive (column) gives by one.

        The identity, but for joints with ``coupling = "mechanical"``: there the drives sit on the logged axes, so that
        drive 2 of a robot with a parallel rod turns joint 2 one way and joint 3 the other. Its transpose takes the
        torques about the model joints to what the drives carry.
        """
        unit_axes = np.eye(self.n_joints)
        combined = np.count_nonzero(self.coupling, axis=1) > 1
        if not (self.mechanical & combined).any():
            return unit_axes
        display_only = combined & ~self.mechanical
        return np.where(display_only[:, None], unit_axes, self.coupling)

    @property
    def drives_of_logged(self) -> Floats:
        """(J, L) how far each drive turns per turn of each logged joint."""
        return np.asarray(np.linalg.inv(self.drive_axes) @ self.coupling)
