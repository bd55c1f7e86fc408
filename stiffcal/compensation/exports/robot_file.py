"""The calibrated robot as a robot file: rows of a convention, with Hayati's β, and the transforms at both ends.

Errors of the links and of the zeros are in the rows. A row's frame sits elsewhere on its link than the one that the
robot file had, so that centres of mass, bearings, ends of beams and the balancing spring's points move along. Springs
and eccentricities are no part of a rigid robot: the export as JSON has their values.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import tomlkit

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.robot.geometry import planned_rows
from stiffcal.campaign.robot.robot_file import (
    GeometryEntry,
    GravityCompensatorEntry,
    JointEntry,
    LinkBeamEntry,
    LinkMass,
    RobotFile,
)
from stiffcal.campaign.robot.transforms import placement_matrix
from stiffcal.campaign.toml.naming import body_number
from stiffcal.campaign.toml.typed import Placement
from stiffcal.compensation.exports.urdf import fitted_frames
from stiffcal.escapes import toml_text
from stiffcal.identification.answers.stated_geometry import HeldEnds, calibrated_rows, held_ends
from stiffcal.mechanics.conventions import Convention
from stiffcal.mechanics.joint_rows import RowsOfChain
from stiffcal.mechanics.rotations import inverse_transform
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.quaternions import quaternion_from_rotation
from stiffcal.wording import significant

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.mechanics.chain import Chain
    from stiffcal.results.identify_result import IdentifyResult

_FAR_M = 10.0
"""Rows that begin farther from the robot than this are warned of."""
_DIGITS = 12
_LEAST_BEARING_M = 1e-6
"""Below it a bearing is at its frame's origin: a lever changes by less than any length is known."""
"""Decimals of metres and degrees; of strict rows all that a number has."""
BEARING_COMMENTS = (
    "# bearing_m: distance of a joint's bearing from the origin of its row's frame, along the axis. The origins move",
    "# with the rows, the bearings of the robot do not. It matters for springs alone, not for positions.",
)
_KEPT = frozenset({"direction", "logged", "coupling", "gear_ratio", "gear_orders"})
"""Keys of a joint's entry that do not depend on where its frame is."""


@dataclass(frozen=True)
class RobotRowsText:
    """A robot file, and what its reader must know."""

    text: str
    """TOML."""
    convention: Convention
    """Of the rows."""
    warnings: list[str]
    """As sentences."""


def robot_rows_text(
    campaign: Campaign,
    identified: IdentifyResult,
    setup: MeasurementSetup | None,
    convention: Convention | None = None,
    *,
    strict: bool = False,
) -> RobotRowsText:
    """Return the calibrated robot as the text of a robot file.

    Parameters
    ----------
    campaign : whose robot it is. identified : the fit whose geometry is written.
    setup : of the states that were fitted, with the frames where registration put them; None: no frames are stated.
    convention : of the rows; None: that of the robot file, modified DH for a URDF.
    strict : without β, also where axes are nearly parallel.
    """
    robot = placed_robot(campaign).with_values(identified.robot_values())
    planned = planned_rows(campaign.robot, campaign.chain)
    planned = planned.in_convention(convention or planned.rows.convention)
    held = HeldEnds((), ()) if setup is None else held_ends(robot, setup.target_names)
    found = calibrated_rows(robot, planned, held, strict=strict)
    moved = [inverse_transform(frame) for frame in found.moved_frames()]
    digits = None if strict else _DIGITS
    calibrated = _robot_file(campaign.robot, robot.adjusted_chain, found, moved, digits)
    frames = {} if setup is None else fitted_frames(robot, setup)
    frames = frames | dict(_frames_on_links(campaign, moved))
    head = [
        f"# {campaign.chain.name} as calibrated in {campaign.name}, fit {identified.fit_id}: rigid, without springs",
        "# and eccentricities; `stiffcal export DIR -o model.json` writes their values.",
        *_frame_comments(frames),
        *(BEARING_COMMENTS if any(entry.bearing_m for entry in calibrated.joints) else ()),
    ]
    far = float(np.abs(found.rows.d).max())
    warnings = []
    if strict and far > _FAR_M:
        warnings.append(
            f"without β, nearly parallel axes have a common normal {significant(far / 1e3)} km away: "
            f"a number rounded in its "
            f"last "
            "digits moves the flange, and masses and bearings of links whose frames are there are left out; "
            "leave out --strict where the controller takes β"
        )
    return RobotRowsText("\n".join(head) + "\n" + _toml(calibrated), found.rows.convention, warnings)


def _robot_file(
    robot: RobotFile, chain: Chain, found: RowsOfChain, moved: list[Floats], digits: int | None
) -> RobotFile:
    """Return the robot file with the calibrated rows, and all that it states of links where their frames are now."""
    rows = found.rows
    written = {entry.name: entry for entry in robot.joints}
    joints = tuple(
        _joint(written.get(name, JointEntry(name=name)), chain, found, moved, k, digits)
        for k, name in enumerate(chain.joint_names)
    )
    calibrated = RobotFile(
        schema_id="stiffcal/robot/1", name=chain.name, convention=rows.convention, joints=joints,
        rated_payload_kg=robot.rated_payload_kg,
        gravity_mps2=(float(chain.gravity[0]), float(chain.gravity[1]), float(chain.gravity[2])),
    )  # fmt: skip
    further: dict[str, Placement | GravityCompensatorEntry | GeometryEntry | dict[str, LinkBeamEntry]] = {}
    for key, transform in (("base", rows.base), ("flange", rows.flange)):
        if not np.allclose(transform, np.eye(4), atol=1e-14):
            further[key] = _placement(transform)
    compensator = robot.gravity_compensator
    if compensator is not None:
        k = compensator.joint - 1
        before = moved[k - 1] if k > 0 else np.eye(4)
        ends = {"arm_m": _place(compensator.arm_m, moved[k]), "anchor_m": _place(compensator.anchor_m, before)}
        further["gravity_compensator"] = compensator.model_copy(update=ends)
    if robot.geometry.model_fields_set:
        further["geometry"] = robot.geometry
    if robot.links:
        further["links"] = {name: _beam(entry, name, chain, moved) for name, entry in robot.links.items()}
    return calibrated.model_copy(update=further)


def _joint(
    entry: JointEntry, chain: Chain, found: RowsOfChain, moved: list[Floats], k: int, digits: int | None
) -> JointEntry:
    """Return a joint's entry with its calibrated row, and its link in the frame that the row gives it."""
    rows, near = found.rows, abs(moved[k][2, 3]) < _FAR_M
    calibrated = JointEntry(
        name=chain.joint_names[k],
        a_m=_number(rows.a[k], digits),
        alpha_deg=_number(np.degrees(rows.alpha[k]), digits),
        d_m=_number(rows.d[k], digits),
        theta_deg=_number(np.degrees(rows.theta[k]), digits),
        link=_link(chain, moved, k, with_mass=near),
    )
    # what of an entry does not depend on where its frame is
    further = {key: value for key in _KEPT & entry.model_fields_set if (value := getattr(entry, key)) is not None}
    if rows.beta[k]:
        further["beta_deg"] = _number(np.degrees(rows.beta[k]), digits)
    if chain.prismatic[k]:
        further["type"], further["limits_m"] = "prismatic", tuple(chain.limits[k].tolist())
    elif np.isfinite(chain.limits[k]).all():
        low, high = np.degrees(chain.limits[k])
        further["limits_deg"] = _number(low, _DIGITS), _number(high, _DIGITS)
    bearing = float(chain.bearing[k] + moved[k][2, 3])
    if near and abs(bearing) > _LEAST_BEARING_M:
        further["bearing_m"] = _number(bearing, _DIGITS)
    return calibrated.model_copy(update=further)


def _link(chain: Chain, moved: list[Floats], k: int, *, with_mass: bool) -> LinkMass:
    """Return a joint's link: its name, and where it is known its mass and centre in its new frame."""
    name = chain.link_names[k]
    if not with_mass or not (chain.masses_known or chain.link_mass[k] > 0.0):
        return LinkMass(name=name)
    return LinkMass(name=name, mass_kg=float(chain.link_mass[k]), com_m=_place(chain.link_com[k], moved[k]))


def _beam(entry: LinkBeamEntry, name: str, chain: Chain, moved: list[Floats]) -> LinkBeamEntry:
    """Return what the robot file states of a beam, its ends in the new frame of its link."""
    beam = chain.beams.get(name)
    k = beam.joint - 1 if beam is not None else chain.link_names.index(name) if name in chain.link_names else None
    ends = {"from_m": entry.from_m, "to_m": entry.to_m}
    placed = {key: _place(end, moved[k]) for key, end in ends.items() if end is not None and k is not None}
    return entry.model_copy(update=placed)


def _toml(robot: RobotFile) -> str:
    """Return a robot file as TOML, the link of each joint on one line."""
    document = robot.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    for joint in document["joints"]:
        inline = tomlkit.inline_table()
        inline.update(joint["link"])
        joint["link"] = inline
    return tomlkit.dumps(document)


def _frames_on_links(campaign: Campaign, moved: list[Floats]) -> Iterator[tuple[str, tuple[str, Floats]]]:
    """Yield (name, (link, link_from_frame)) of the manifest's frames on links, in the links' new frames."""
    names = campaign.chain.link_names
    for name, frame in campaign.manifest.frames.items():
        body = body_number(frame.parent, names)
        if body is not None and 0 < body <= len(names) and not frame.estimate:
            yield name, (frame.parent, moved[body - 1] @ placement_matrix(frame))


def _frame_comments(frames: dict[str, tuple[str, Floats]]) -> Iterator[str]:
    """Yield comment lines with the frames of campaign.toml that belong to this robot."""
    if frames:
        yield "# With it belong these frames in campaign.toml:"
    for name, (parent, transform) in frames.items():
        yield f"#   [frames.{toml_text.key(name)}]"
        yield f"#   {toml_text.pair('parent', parent)}"
        placement = _placement(transform)
        yield f"#   xyz_m = {list(placement.xyz_m)}"
        if placement.quaternion_wxyz is not None:
            yield f"#   quaternion_wxyz = {list(placement.quaternion_wxyz)}"


def _placement(transform: Floats) -> Placement:
    """Return a rigid transform as a robot file writes it."""
    x, y, z = (_number(value, _DIGITS) for value in transform[:3, 3])
    if np.allclose(transform[:3, :3], np.eye(3), atol=1e-14):
        return Placement(xyz_m=(x, y, z))
    a, b, c, d = (_number(value, 15) for value in quaternion_from_rotation(transform[:3, :3]).tolist())
    return Placement(xyz_m=(x, y, z), quaternion_wxyz=(a, b, c, d))


def _place(place: Floats | tuple[float, ...], moved: Floats) -> tuple[float, float, float]:
    """Return a place on a link in the link's new frame."""
    x, y, z = (_number(value, _DIGITS) for value in moved[:3, :3] @ np.asarray(place) + moved[:3, 3])
    return x, y, z


def _number(value: float, digits: int | None) -> float:
    # adding zero turns −0 into 0
    return float(value if digits is None else round(float(value), digits)) + 0.0
