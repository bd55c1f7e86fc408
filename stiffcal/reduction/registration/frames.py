"""Frames that registration found: where they are, how well that is known, and what of it is a convention."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from stiffcal.arrays import Floats
from stiffcal.document_arrays import Matrix, VectorWithGaps
from stiffcal.documents import Number, OrAbsent

Axis: TypeAlias = Literal["x", "y", "z", "rx", "ry", "rz"]
AXES: tuple[Axis, ...] = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True, slots=True)
class RegisteredFrame:
    """A frame found."""

    parent_from_frame: Matrix
    """(4, 4), m."""
    std: VectorWithGaps
    """(6,) standard uncertainty: translation m, rotation rad; NaN where it was not looked for."""
    by_convention: OrAbsent[list[Axis]] = None
    """Axes, of the parent, along and about which it stays as campaign.toml has it, because the poses do not separate
    that from another frame; None where there are none.
    """
    cannot_be_separated_from: OrAbsent[list[str]] = None
    """Names of those frames."""


@dataclass(frozen=True, slots=True)
class RegistrationSummary:
    """Frames found, and what is left between kinematics and readings."""

    frames: dict[str, RegisteredFrame]
    """By name."""
    rms_m: float
    """Of places."""
    rms_rad: Number
    """Of turns; NaN for positions only."""
    n_poses: int
    """Different poses used."""


@dataclass(frozen=True)
class Registration:
    """Frames found."""

    frames: dict[str, Floats]
    """Name to (4, 4) parent_from_frame, m."""
    uncertainty: dict[str, Floats]
    """Name to (6,) standard uncertainty: translation m, rotation rad; NaN where it was not looked for."""
    rms_m: float
    """Rms distance between kinematics and readings."""
    rms_rad: float
    """Rms angle between kinematics and readings; NaN for positions only."""
    n_poses: int
    """Number of different poses used."""
    held: dict[str, tuple[Axis, ...]] = field(default_factory=dict)
    """Name to the axes along and about which a frame stays as the manifest has it, by convention."""

    @property
    def summary(self) -> RegistrationSummary:
        """What results hold of it."""
        registered = {}
        for name, frame in self.frames.items():
            by_convention = list(self.held.get(name, ()))
            others = [other for other in self.frames if other not in self.held] if by_convention else []
            registered[name] = RegisteredFrame(frame, self.uncertainty[name], by_convention or None, others or None)
        return RegistrationSummary(registered, self.rms_m, self.rms_rad, self.n_poses)
