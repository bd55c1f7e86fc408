"""robot.toml, typed: geometry, couplings, masses."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema

from stiffcal.campaign.robot.sizes import Anywhere, Degrees, Gravity, Length, Mass, PlaceOnRobot, PositiveLength, Ratio
from stiffcal.campaign.toml.typed import (
    Counting,
    Interval,
    Name,
    Placement,
    Positive,
    TomlTable,
    WrongValueError,
    at_most,
)

MOST_JOINTS = 100
"""Of one arm: humanoids have thirty; what a hundred cost is still fast."""
MOST_CORNERS, MOST_HOLES = 500, 20
"""Of an outline, and of a drawn section: the mesh grows with both."""


class LinkMass(TomlTable):
    """The link a joint moves: its name, and mass and centre of mass (in the joint's own frame) where known."""

    name: Name | None = None
    mass_kg: Mass | None = None
    com_m: PlaceOnRobot | None = None

    look_alikes: ClassVar[dict[str, str]] = {"mass": "mass_kg", "com": "com_m"}


class JointEntry(TomlTable):
    """One joint, base to wrist.

    Attributes
    ----------
    type : "revolute", or "prismatic" where the joint moves along its axis: its position is added to d in place of θ.
        With a URDF its own types count.
    a_m, alpha_deg, d_m, theta_deg : the convention's row; with a URDF only `theta_deg` (added to the model angle).
    beta_deg : Hayati's turn about y, after a and α: where the axes are nearly parallel.
    limits_deg : of the logged angle. limits_m : of a prismatic joint's logged position, which needs them.
    direction : -1 where the logged angle runs against the axis.
    logged : joint name to coefficient, where the model angle is a combination of logged ones.
    coupling : "display", or "mechanical" where the drives sit on the combined axes.
    gear_ratio : motor side / joint side, sign allowed. gear_orders : per joint turn.
    bearing_m : where on its axis the bearing sits, from the frame's origin.
    """

    name: Name
    type: Literal["revolute", "prismatic"] | None = None
    a_m: Length = 0.0
    alpha_deg: Degrees = 0.0
    beta_deg: Degrees = 0.0
    d_m: Anywhere = 0.0
    theta_deg: Degrees = 0.0
    limits_deg: Interval | None = None
    limits_m: Interval | None = None
    direction: Literal[1, -1] = 1
    logged: dict[str, Ratio] | None = None
    coupling: Literal["display", "mechanical"] = "display"
    gear_ratio: Ratio = 1.0
    gear_orders: Annotated[tuple[Counting, ...], Field(strict=False), at_most(100, "name the orders that show")] = ()
    bearing_m: Length = 0.0
    link: LinkMass = LinkMass()

    look_alikes: ClassVar[dict[str, str]] = {
        "a": "a_m", "alpha": "alpha_deg", "d": "d_m", "theta": "theta_deg", "beta": "beta_deg", "limits": "limits_deg",
        "limits_mm": "limits_m", "kind": "type",
        "sign": "direction",
        "offset_deg": "theta_deg", "ratio": "gear_ratio", "mass_kg": "link", "a_mm": "a_m", "d_mm": "d_m",
    }  # fmt: skip


class GravityCompensatorEntry(TomlTable):
    """The balancing spring or cylinder in parallel with a joint.

    Attributes
    ----------
    joint : from 1. anchor_m : on the link before, in its frame. arm_m : on the link moved, in its frame.
    rate_N_m : N/m; where it is stated, and masses are known, the spring counts as they do. preload_N : N at the joint's
        zero.
    """

    joint: Counting
    anchor_m: PlaceOnRobot
    arm_m: PlaceOnRobot
    rate_N_m: Positive | None = None
    preload_N: float = 0.0


def _outline(value: object) -> tuple[tuple[float, float], ...]:
    points: list[Any] = list(value) if isinstance(value, list | tuple) else []
    if len(points) > MOST_CORNERS:
        raise WrongValueError(f"an outline with {len(points)} points, more than {MOST_CORNERS}", "draw it with fewer")
    if len(points) < 3 or not all(isinstance(point, list | tuple) and len(point) == 2 for point in points):
        raise WrongValueError(
            "an outline is three or more points", "write [[x2, x3], …] in m, in order around the section"
        )
    return tuple((float(a), float(b)) for a, b in points)


Outline: TypeAlias = Annotated[
    tuple[tuple[float, float], ...],
    BeforeValidator(_outline),
    WithJsonSchema(
        {
            "type": "array",
            "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "minItems": 3,
        }
    ),
]


class BeamSectionEntry(TomlTable):
    """A beam's section: its outline, or its stiffnesses.

    Attributes
    ----------
    outline : points [x2, x3], m.
    wall_m : thickness of the wall all round, where the section is hollow.
    holes : outlines of the hollows, where the wall is not the same all round.
    E_Pa : Young's modulus. G_Pa : shear modulus; without moduli a drawn section gives fibres and warping alone.
    EI : N·m², both planes alike; EI2, EI3 : bending about x2 and x3.
    GJ : N·m². EA : N.
    """

    outline: Outline | None = None
    wall_m: PositiveLength | None = None
    holes: Annotated[tuple[Outline, ...], Field(strict=False), at_most(MOST_HOLES, "draw it with fewer")] = ()
    E_Pa: Positive | None = None
    G_Pa: Positive | None = None
    EI: Positive | None = None
    EI2: Positive | None = None
    EI3: Positive | None = None
    GJ: Positive | None = None
    EA: Positive | None = None


class LinkBeamEntry(TomlTable):
    """Where and how a link bends.

    Attributes
    ----------
    from_m, to_m : the beam's ends in the link's joint frame, where they are not the joint origins.
    section : its section. warping_decay_m : length over which held-back warping decays.
    expansion_per_K : thermal expansion of what it is made of (cast iron 1.05e-5, steel 1.2e-5, aluminium 2.3e-5).
    """

    from_m: PlaceOnRobot | None = None
    to_m: PlaceOnRobot | None = None
    section: BeamSectionEntry | None = None
    warping_decay_m: PositiveLength | None = None
    expansion_per_K: float | None = Field(None, ge=-1e-4, le=1e-3)


LENGTH_SIGMA_M, ANGLE_SIGMA_DEG = 5e-4, 0.02
"""Of industrial robots as built: nominal lengths and angles of a robot that was not calibrated miss its places by one
or two millimetres, which half a millimetre per length and a fiftieth of a degree per angle make."""


class GeometryEntry(TomlTable):
    """How well lengths and angles between the joints are known, as standard deviations.

    Attributes
    ----------
    length_sigma_m : of each length; 0 where the geometry is exact. Absent: 0.5 mm, or what absolute places show.
    angle_sigma_deg : of each angle. Absent: 0.02°, or what absolute places show.
    """

    length_sigma_m: Annotated[float, Field(ge=0.0, le=0.1)] | None = None
    angle_sigma_deg: Annotated[float, Field(ge=0.0, le=5.0)] | None = None

    look_alikes: ClassVar[dict[str, str]] = {"length": "length_sigma_m", "angle": "angle_sigma_deg"}


class RobotFile(TomlTable):
    """robot.toml.

    Attributes
    ----------
    convention : "dh" (Denavit-Hartenberg) or "modified-dh" (Craig); with `urdf` none.
    urdf : path next to robot.toml; base_link, tip_link where it branches. Its meshes are what `view` draws, where they
        lie in the campaign folder.
    rated_payload_kg : what the maker allows at the flange; payloads are proposed within 2 to 100 % of it.
    gravity_mps2 : in base axes. joints : base to wrist; with a URDF only those with entries of their own.
    base : where the rows begin, in the robot's base frame; not with a URDF.
    flange : in the last frame of the convention (DH: after a, α and d of the last row; URDF: the tip link).
    """

    schema_id: Literal["stiffcal/robot/1"] = Field(alias="schema")
    name: Name | None = None
    convention: Literal["dh", "modified-dh"] | None = None
    urdf: Name | None = None
    base_link: Name | None = None
    tip_link: Name | None = None
    rated_payload_kg: Positive | None = None
    gravity_mps2: Gravity = (0.0, 0.0, -9.81)
    joints: Annotated[
        tuple[JointEntry, ...], Field(strict=False), at_most(MOST_JOINTS, "describe one arm, base to flange")
    ] = ()
    base: Placement = Placement()
    flange: Placement = Placement()
    gravity_compensator: GravityCompensatorEntry | None = None
    geometry: GeometryEntry = GeometryEntry()
    links: dict[str, LinkBeamEntry] = Field(default_factory=dict)

    look_alikes: ClassVar[dict[str, str]] = {
        "joint": "joints",
        "gravity": "gravity_mps2",
        "payload_kg": "rated_payload_kg",
        "link": "links",
    }
