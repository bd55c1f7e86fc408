"""The robot as URDF, calibrated where its geometry was identified, each joint with the stiffness of its drive.

Errors of the links and of the zeros are in the joints' origins, masses stay in the frames of their joints; the tracker
and the targets that were found together with them are links of their own. Other springs and eccentricities are no part
of a rigid robot: the export as JSON has their values.

URDF has no stiffness: it stands in an element of its own, which readers that do not know it pass over. Joint angles
in the file are the chain's own; where logged angles are coupled, a comment states how they become these.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.rotations import rpy_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import FramePosition, with_found_frames
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.summary import Where
from stiffcal.results.identify_result import IdentifyResult

_STIFFNESS = {"rad/(N·m)": "N*m/rad", "m/N": "N/m"}
"""Unit of a compliance to that of its inverse, as the elements of the URDF name it."""


def urdf_text(campaign: Campaign, identified: IdentifyResult, setup: MeasurementSetup | None = None) -> str:
    """Return the robot as URDF.

    Parameters
    ----------
    campaign : whose robot it is.
    identified : the fit whose geometry and joint stiffness is written.
    setup : of the states that were fitted, with the frames where registration put them; None: frames are left out.
    """
    robot = placed_robot(campaign).with_values(identified.robot_values())
    chain = robot.adjusted_chain
    root = ElementTree.Element("robot", name=chain.name or campaign.name)
    coupled = not np.allclose(chain.coupling, np.diag(np.diag(chain.coupling)))
    if coupled:
        rows = "; ".join(
            f"{name} = "
            + " + ".join(f"{c:g} {chain_joint}" for c, chain_joint in zip(row, chain.joint_names, strict=True) if c)
            for name, row in zip(chain.joint_names, chain.coupling, strict=True)
        )
        root.append(ElementTree.Comment(f" angles here from logged ones: {rows} "))
    ElementTree.SubElement(root, "link", name="base")
    parent = "base"
    for k, joint_name in enumerate(chain.joint_names):
        # The model's zero (theta) goes into the origin, so that a joint angle of zero is a logged zero.
        origin = chain.fixed[k] @ _about_z(float(chain.offset[k]))
        link_name = chain.link_names[k] if len(set(chain.link_names)) == chain.n_joints else f"link{k + 1}"
        joint = ElementTree.SubElement(
            root, "joint", name=joint_name, type="prismatic" if chain.prismatic[k] else "revolute"
        )
        _origin(joint, origin)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=link_name)
        sign = 1.0 if coupled or chain.coupling[k, k] > 0.0 else -1.0
        ElementTree.SubElement(joint, "axis", xyz=f"0 0 {sign:g}")
        low, high = chain.limits[k] if np.isfinite(chain.limits[k]).all() else (-2.0 * np.pi, 2.0 * np.pi)
        ElementTree.SubElement(joint, "limit", lower=_word(low), upper=_word(high), effort="0", velocity="0")
        _stiffness(joint, identified, k + 1, ("rad/(N·m)", "m/N") if chain.prismatic[k] else ("rad/(N·m)",))
        link = ElementTree.SubElement(root, "link", name=link_name)
        if chain.link_mass[k] > 0.0:
            _inertial(link, float(chain.link_mass[k]), chain.link_com[k])
        parent = link_name
    flange = ElementTree.SubElement(root, "joint", name="flange_joint", type="fixed")
    _origin(flange, chain.flange)
    ElementTree.SubElement(flange, "parent", link=parent)
    ElementTree.SubElement(flange, "child", link="flange")
    ElementTree.SubElement(root, "link", name="flange")
    if setup is not None:
        taken = {str(element.get("name")) for element in root}
        for name, (body, transform) in fitted_frames(robot, setup).items():
            if body in taken and name not in taken:
                _fixed_frame(root, name, body, transform)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def fitted_frames(robot: CompliantRobot, setup: MeasurementSetup) -> dict[str, tuple[str, Floats]]:
    """Return name to (body, (4, 4) body_from_frame) of the frames that were found together with the robot.

    Parameters
    ----------
    robot : with the fitted values. setup : with the frames where registration put them.
    """
    found = with_found_frames(robot, setup)
    trackers = {tracker.frame: tracker.base_from_frame for tracker in found.trackers}
    result: dict[str, tuple[str, Floats]] = {}
    for placed in robot.placed:
        name = placed.place.frame
        if not isinstance(placed.effect, FramePosition) or name is None:
            continue
        if name not in setup.target_names:
            result[name] = "base", trackers[name]
        elif (target := found.targets[setup.target_names.index(name)]).body == robot.chain.n_joints + 1:
            result[name] = "flange", target.transform
    return result


def _fixed_frame(root: ElementTree.Element, name: str, body: str, transform: Floats) -> None:
    joint = ElementTree.SubElement(root, "joint", name=f"{name}_joint", type="fixed")
    _origin(joint, transform)
    ElementTree.SubElement(joint, "parent", link=body)
    ElementTree.SubElement(joint, "child", link=name)
    ElementTree.SubElement(root, "link", name=name)


def _stiffness(joint: ElementTree.Element, identified: IdentifyResult, number: int, units: tuple[str, ...]) -> None:
    for parameter in identified.parameters:
        if parameter.where == Where(joints=[number]) and parameter.unit in units:
            attributes: dict[str, Any] = {"effect": parameter.effect, "unit": _STIFFNESS[parameter.unit]}
            if parameter.known_stiffness is not None:
                attributes["value"] = _word(parameter.known_stiffness)
            if parameter.known_stiffness_std is not None:
                attributes["standard_uncertainty"] = _word(parameter.known_stiffness_std)
            ElementTree.SubElement(joint, "stiffness", attributes)


def _inertial(link: ElementTree.Element, mass: float, com: Floats) -> None:
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_words(com), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=_word(mass))
    # Rotational inertia plays no part in standing still and is not known.
    ElementTree.SubElement(inertial, "inertia", ixx="0", ixy="0", ixz="0", iyy="0", iyz="0", izz="0")


def _origin(element: ElementTree.Element, transform: Floats) -> None:
    ElementTree.SubElement(
        element, "origin", xyz=_words(transform[:3, 3]), rpy=_words(rpy_from_rotation(transform[:3, :3]))
    )


def _about_z(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _words(values: Floats) -> str:
    return " ".join(_word(float(value)) for value in values)


def _word(value: float) -> str:
    # Adding zero turns −0 into 0.
    return f"{value + 0.0:.12g}"
