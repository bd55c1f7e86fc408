"""The robot as URDF, each joint with the stiffness of its drive.

URDF has no stiffness: it stands in an element of its own, which readers that do not know it pass over. Joint angles
in the file are the chain's own; where logged angles are coupled, a comment states how they become these.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.mechanics.rotations import rpy_from_rotation
from stiffcal.model.summary import Where
from stiffcal.results.identify_result import IdentifyResult


def urdf_text(campaign: Campaign, identified: IdentifyResult) -> str:
    """Return the robot as URDF.

    Parameters
    ----------
    campaign : whose robot it is.
    identified : the fit whose joint stiffness is written.
    """
    chain = campaign.chain
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
        joint = ElementTree.SubElement(root, "joint", name=joint_name, type="revolute")
        _origin(joint, origin)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=link_name)
        sign = 1.0 if coupled or chain.coupling[k, k] > 0.0 else -1.0
        ElementTree.SubElement(joint, "axis", xyz=f"0 0 {sign:g}")
        low, high = chain.limits[k] if np.isfinite(chain.limits[k]).all() else (-2.0 * np.pi, 2.0 * np.pi)
        ElementTree.SubElement(joint, "limit", lower=_word(low), upper=_word(high), effort="0", velocity="0")
        _stiffness(joint, identified, k + 1)
        link = ElementTree.SubElement(root, "link", name=link_name)
        if chain.link_mass[k] > 0.0:
            _inertial(link, float(chain.link_mass[k]), chain.link_com[k])
        parent = link_name
    flange = ElementTree.SubElement(root, "joint", name="flange_joint", type="fixed")
    _origin(flange, chain.flange)
    ElementTree.SubElement(flange, "parent", link=parent)
    ElementTree.SubElement(flange, "child", link="flange")
    ElementTree.SubElement(root, "link", name="flange")
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _stiffness(joint: ElementTree.Element, identified: IdentifyResult, number: int) -> None:
    for parameter in identified.parameters:
        if parameter.where == Where(joints=[number]) and parameter.unit == "rad/(N·m)":
            attributes: dict[str, Any] = {"effect": parameter.effect, "unit": "N*m/rad"}
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
