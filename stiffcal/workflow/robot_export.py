"""The calibrated robot as a robot file: rows of a convention, with Hayati's β, and the transforms at both ends.

Errors of the links and of the zeros are in the rows. A row's frame sits elsewhere on its link than the one that the
robot file had, so that centres of mass, bearings, ends of beams and the balancing spring's points move along. Springs
and eccentricities are no part of a rigid robot: they stay in model.toml.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import tomlkit

from stiffcal.arrays import Floats
from stiffcal.campaign.geometry import planned_rows
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.naming import body_number
from stiffcal.campaign.robot_file import JointEntry, RobotFile
from stiffcal.campaign.transforms import placement_matrix
from stiffcal.identification.stated_geometry import HeldEnds, calibrated_rows, held_ends
from stiffcal.mechanics.joint_rows import Convention, RowsOfChain
from stiffcal.mechanics.rotations import inverse_transform
from stiffcal.model.campaign_effects import placed_robot
from stiffcal.quaternions import quaternion_from_rotation
from stiffcal.workflow.urdf_export import fitted_frames

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.mechanics.chain import Chain
    from stiffcal.results.identify_result import IdentifyResult

_FAR_M = 10.0
"""Rows that begin farther from the robot than this are warned of."""
_DIGITS = 12
"""Decimals of metres and degrees; of strict rows all that a number has."""


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
    document = _document(campaign.robot, robot.adjusted_chain, found, moved, digits)
    frames = {} if setup is None else fitted_frames(robot, setup)
    frames = frames | dict(_frames_on_links(campaign, moved))
    head = [
        f"# {campaign.chain.name} as calibrated in {campaign.name}, fit {identified.fit_id}: rigid, without springs",
        "# and eccentricities, which are in model.toml.",
        *_frame_comments(frames),
    ]
    far = float(np.abs(found.rows.d).max())
    warnings = []
    if strict and far > _FAR_M:
        warnings.append(
            f"without β nearly parallel axes put a common normal {far / 1e3:.3g} km away: a number rounded in its last "
            "digits moves the flange, and masses and bearings of links whose frames are there are left out; "
            "leave out --strict where the controller takes β"
        )
    return RobotRowsText("\n".join(head) + "\n" + tomlkit.dumps(document), found.rows.convention, warnings)


def _document(
    robot: RobotFile, chain: Chain, found: RowsOfChain, moved: list[Floats], digits: int | None
) -> dict[str, Any]:
    """Return the robot file's tables."""
    rows = found.rows
    written = {entry.name: entry for entry in robot.joints}
    document: dict[str, Any] = {"schema": "stiffcal/robot/1", "name": chain.name, "convention": rows.convention}
    document["gravity_mps2"] = list(robot.gravity_mps2)
    document["joints"] = []
    for k, name in enumerate(chain.joint_names):
        entry = written.get(name, JointEntry(name=name))
        table: dict[str, Any] = {
            "name": name,
            "a_m": _number(rows.a[k], digits),
            "alpha_deg": _number(np.degrees(rows.alpha[k]), digits),
            "d_m": _number(rows.d[k], digits),
            "theta_deg": _number(np.degrees(rows.theta[k]), digits),
        }
        if rows.beta[k]:
            table["beta_deg"] = _number(np.degrees(rows.beta[k]), digits)
        table |= dict(_kept_keys(entry, chain, k))
        near = abs(moved[k][2, 3]) < _FAR_M
        bearing = float(chain.bearing[k] + moved[k][2, 3])
        if near and round(bearing, _DIGITS):
            table["bearing_m"] = _number(bearing, _DIGITS)
        link: dict[str, Any] = {"name": chain.link_names[k]}
        if near and (chain.masses_known or chain.link_mass[k] > 0.0):
            link["mass_kg"] = float(chain.link_mass[k])
            link["com_m"] = _place(chain.link_com[k], moved[k])
        inline: Any = tomlkit.inline_table()
        inline.update(link)
        table["link"] = inline
        document["joints"].append(table)
    for key, transform in (("base", rows.base), ("flange", rows.flange)):
        if not np.allclose(transform, np.eye(4), atol=1e-14):
            document[key] = _placement(transform)
    compensator = robot.gravity_compensator
    if compensator is not None:
        k = compensator.joint - 1
        table = compensator.model_dump(exclude_none=True)
        table["arm_m"] = _place(np.array(compensator.arm_m), moved[k])
        before = moved[k - 1] if k > 0 else np.eye(4)
        table["anchor_m"] = _place(np.array(compensator.anchor_m), before)
        document["gravity_compensator"] = table
    if robot.geometry.model_fields_set:
        document["geometry"] = robot.geometry.model_dump(exclude_none=True)
    links = {name: _beam_table(robot, name, chain, moved) for name in robot.links}
    return document | ({"links": links} if links else {})


def _kept_keys(entry: JointEntry, chain: Chain, k: int) -> Iterator[tuple[str, Any]]:
    """Yield what of a joint's entry does not depend on where its frame is."""
    if np.isfinite(chain.limits[k]).all():
        yield "limits_deg", [_number(limit, _DIGITS) for limit in np.degrees(chain.limits[k])]
    for key in ("direction", "logged", "coupling", "gear_ratio", "gear_orders"):
        if key in entry.model_fields_set and getattr(entry, key) is not None:
            value = getattr(entry, key)
            yield key, list(value) if isinstance(value, tuple) else value


def _beam_table(robot: RobotFile, name: str, chain: Chain, moved: list[Floats]) -> dict[str, Any]:
    """Return what the robot file states of a beam, its ends in the new frame of its link."""
    table = robot.links[name].model_dump(exclude_none=True, exclude_unset=True)
    beam = chain.beams.get(name)
    k = beam.joint - 1 if beam is not None else chain.link_names.index(name) if name in chain.link_names else None
    for key in ("from_m", "to_m"):
        if key in table and k is not None:
            table[key] = _place(np.array(table[key]), moved[k])
    return table


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
        yield f"#   [frames.{name}]"
        yield f'#   parent = "{parent}"'
        for key, value in _placement(transform).items():
            yield f"#   {key} = {value}"


def _placement(transform: Floats) -> dict[str, Any]:
    """Return a rigid transform as a robot file writes it."""
    table: dict[str, Any] = {"xyz_m": [_number(value, _DIGITS) for value in transform[:3, 3]]}
    if not np.allclose(transform[:3, :3], np.eye(3), atol=1e-14):
        table["quaternion_wxyz"] = [
            _number(value, 15) for value in quaternion_from_rotation(transform[:3, :3]).tolist()
        ]
    return table


def _place(place: Floats, moved: Floats) -> list[float]:
    """Return a place on a link in the link's new frame."""
    return [_number(value, _DIGITS) for value in moved[:3, :3] @ place + moved[:3, 3]]


def _number(value: float, digits: int | None) -> float:
    # adding zero turns −0 into 0
    return float(value if digits is None else round(float(value), digits)) + 0.0
