"""Links whose weight does not act where the robot file puts it."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.absolute_places_needed import lacks_absolute_places
from stiffcal.model.effect import (
    RZ,
    Covariate,
    Kind,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Values,
    joint_node,
)
from stiffcal.model.laws.link_moments import LinkMoments

_SOURCE = "a link of 60 kg whose centre of mass is 50 mm from where a drawing without motors and cables has it"
# Sine of the angle to gravity below which an axis counts as vertical: weight turns it by no more than its own tilt.
_VERTICAL = 1e-3
_NO_MASSES = "the links' masses in robot.toml"


class LinkWeight(LinkMoments):
    """A link's first moment, its mass times the place of its centre, differs from the robot file's.

    Law: M = R (m + (mx, my, 0)) × g, the moment of the weight of link k about the origin of its joint's frame, with m
    the first moment of robot.toml, in the joint's axes, and R its rotation. Every joint inboard carries the difference.
    Of mass and first moment of a link only two numbers act on springs of joints: the mass and the part along the axis
    act on the previous joint only, and are included in its parameters (regrouping; Gautier and Khalil 1990; Khalil and
    Dombre, Modeling, Identification and Control of Robots, 2002, ch. 9).

    Assumes masses that are right enough for the forces in links and bearings; what differs there by regrouping is of
    second order.

    Limits: weight shows through compliances alone, as compliance times moment. Where the numbers of all links are free
    and nothing but weight acts, one common scale of moments and compliances is unknown: a known payload, a measured
    wrench or the motors' torques at rest (``torque_gain_sigma``) determine it. The link of a joint whose axis is
    vertical in every pose is no place, nor is that of a prismatic joint: it does not turn against the link before,
    whose moments hold its own.
    """

    name = "link-weight"
    kind = Kind.CONFIGURATION
    place_kind = "links"
    summary = "first moment of mass of a link differs from the robot file"
    parameters = tuple(
        ParameterSpec(
            f"m{axis}",
            "kg·m",
            f"true minus robot file's first moment along the joint's {axis} axis",
            -1e4,
            1e4,
            3.0,
            _SOURCE,
            ParameterRole.SETUP,
        )
        for axis in "xy"
    )
    needs = ("absolute poses of a robot whose links' masses are in robot.toml",)
    looks_like = ("joint-compliance", "periodic-stiffness", "joint-eccentricity")
    fingerprint = "the positions sag as by an additional weight on one link, with or without payload"
    how_to_check = "Move the joint slowly back and forth at several angles; the mean of both motor torques is weight."
    largest = float("inf")
    """kg·m, of a first moment on the robot at hand (`at`)."""

    def at(self, place: Place, chain: Chain) -> LinkWeight:
        """Return the effect with the largest first moment that can be: all the mass that the link carries, at reach.

        By regrouping, the moment of a link holds errors of the links beyond it; no centre lies outside the robot.
        """
        limited = copy(self)
        carried = float(chain.link_mass[chain.joint_of_link[place.link] - 1 :].sum())
        if chain.masses_known and carried > 0.0:
            limited.largest = carried * float(np.linalg.norm(chain.fixed[:, :3, 3], axis=1).sum())
        return limited

    def impossible(self, values: Values) -> str | None:
        """A centre of mass lies within the robot's reach."""
        moment = float(np.hypot(values.get("mx", 0.0), values.get("my", 0.0)))
        return "the centre of mass would lie outside the robot" if moment > self.largest else None

    def places(self, chain: Chain) -> list[Place]:
        """Return the links with a mass, but for those before the first axis that is not vertical."""
        down = chain.gravity / max(float(np.linalg.norm(chain.gravity)), 1e-12)
        rotation, upright, places = np.eye(3), True, []
        for name, joint in sorted(chain.joint_of_link.items(), key=lambda entry: entry[1]):
            rotation = rotation @ chain.fixed[joint - 1][:3, :3]
            if joint in chain.prismatic_joints:
                continue  # it does not turn against the link before: their moments are one sum
            upright = upright and float(np.linalg.norm(np.cross(rotation[:, 2], down))) < _VERTICAL
            if not upright and chain.link_mass[joint - 1] > 0.0:
                places.append(Place("links", (), name))
        return places

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Displacements hardly depend on weight; without masses there is no weight."""
        missing = lacks_absolute_places(states)
        if missing is not None:
            return missing
        return None if chain.masses_known else _NO_MASSES

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """Shift the link's centre of mass across its joint's axis, by the moment over the mass."""
        moment = np.array([values.get("mx", 0.0), values.get("my", 0.0)])
        link = chain.joint_of_link[place.link] - 1
        if not moment.any() or chain.link_mass[link] <= 0.0:
            return chain
        centres = chain.link_com.copy()
        centres[link, :2] += moment / chain.link_mass[link]
        return replace(chain, link_com=centres)

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque on the link's joint."""
        joint = chain.joint_of_link[place.link]
        return Covariate(f"torque on joint {joint}", "N·m", loads.wrench[joint_node(joint), RZ])
