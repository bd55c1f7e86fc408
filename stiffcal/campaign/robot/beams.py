"""Where links bend: beam frames from joint to joint, physics section 2, row link-beam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.toml.naming import beam_name
from stiffcal.mechanics.chain import BeamFrame

# Physics section 2: links shorter than 50 mm are no place for a beam.
SHORTEST_BEAM = 0.050

# Below this sine two axes count as parallel: what is left of one across the other would be rounding.
PARALLEL = 1e-6


def link_beams(
    robot: RobotFile, fixed: Floats, bearing: Floats, link_names: tuple[str, ...], prismatic: tuple[bool, ...]
) -> dict[str, BeamFrame]:
    """Return the beams of all links that lie between two joints and are long enough, by link name.

    The beam goes from the inboard joint's node to the outboard joint's node, that is from the joint origins, moved by
    ``bearing_m`` along the axes. Why moved: origins differ between DH, modified DH and URDF, bearings do not.

    Parameters
    ----------
    robot : for ``[links.NAME] from_m, to_m``, in the link's joint frame.
    fixed : (J, 4, 4) joint to joint at zero angle, m.
    bearing : (J,) m along each axis.
    link_names : J names. Six axes: the links of joints 2 and 3 are called `swing` and `arm` here, whatever their own
        name, unless the file calls some link so.
    prismatic : J, True where the joint moves along its axis: the link before it has no fixed length, and is a beam only
        up to a ``to_m`` of its own.
    """
    beams = {}
    for k in range(len(fixed)):
        name = beam_name(k, link_names)
        entry = robot.links.get(name) or robot.links.get(link_names[k])
        start, end = np.array([0.0, 0.0, bearing[k]]), None
        outboard_axis = np.array([0.0, 0.0, 1.0])
        if k + 1 < len(fixed) and prismatic[k + 1] and (entry is None or entry.to_m is None):
            continue
        if k + 1 < len(fixed):
            outboard_axis = fixed[k + 1, :3, 2]
            end = fixed[k + 1, :3, 3] + bearing[k + 1] * outboard_axis
        if entry is not None and entry.from_m is not None:
            start = np.array(entry.from_m)
        if entry is not None and entry.to_m is not None:
            end = np.array(entry.to_m)
        if end is not None and np.linalg.norm(end - start) >= SHORTEST_BEAM:
            beam = _beam(k + 1, start, end, outboard_axis)
            if entry is not None:
                beam = replace(beam, warping_decay=entry.warping_decay_m, expansion=entry.expansion_per_K)
            beams[name] = beam
    return beams


def _beam(joint: int, start: Floats, end: Floats, outboard_axis: Floats) -> BeamFrame:
    """Lay the beam frame: x1 along, x3 the inboard axis (z) made perpendicular to it, x2 = x3 × x1."""
    length = float(np.linalg.norm(end - start))
    x1 = (end - start) / length
    for axis in (np.array([0.0, 0.0, 1.0]), outboard_axis, np.array([1.0, 0.0, 0.0])):
        across = axis - (axis @ x1) * x1
        if np.linalg.norm(across) > PARALLEL:
            break
    x3 = across / np.linalg.norm(across)
    transform = np.eye(4)
    transform[:3, :3] = np.column_stack([x1, np.cross(x3, x1), x3])
    transform[:3, 3] = end
    return BeamFrame(joint, transform, length)
