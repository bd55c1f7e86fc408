"""Links that were not built as the robot file describes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.absolute_places_needed import lacks_absolute_places
from stiffcal.model.effect import RX, RY, TX, TY, Geometry, ParameterSpec, Place, Term, Values, joint_node

_SOURCE = "assembly of industrial arms: some tenths of a millimetre and of a milliradian"
# What assembly leaves at most; an estimate known no better adds nothing.
_WORST_LENGTH, _WORST_ANGLE = 5e-3, 5e-3


class LinkGeometry(Geometry):
    """The axis of a joint on the previous link differs from the robot file by a shift and a tilt.

    Law: T = N · Trans(x, y, 0) · Exp(rx, ry, 0) · Rz(θ), with N the joint's frame on the link before at model angle 0,
    z along the axis. The shift along the axis and the turn about it are left out at every joint, because the next
    joint's frame or the target takes them: 4 numbers per joint and the target's are complete (Hayati 1983; Everett,
    Driels and Mooring 1987). A tracker that is estimated takes the place of joint 1's four. Of a prismatic joint only
    the direction of its axis counts, T = N · Exp(rx, ry, 0) · Tz(q): a shift of it is one of the next joint. A chain of
    r revolute and p prismatic joints has 4 r + 2 p numbers and the target's.

    Assumes rigid links; what bends under weight is compliance.

    Limits: errors of the links and of the zeros of the joints are one set: the zero of a joint is in the tilts and
    shifts of the joint after it. Where the tracker stands cannot be separated from joint 1's numbers, nor the target's
    place from the last joint's zero.
    """

    name = "link-geometry"
    place_kind = "joints"
    summary = "the joint axis is shifted and tilted relative to the previous link"
    includes = ("joint-offset",)
    parameters = (
        ParameterSpec("x", "m", "shift of the axis along x", -0.05, 0.05, 3e-4, _SOURCE, tolerance=_WORST_LENGTH),
        ParameterSpec("y", "m", "shift of the axis along y", -0.05, 0.05, 3e-4, _SOURCE, tolerance=_WORST_LENGTH),
        ParameterSpec("rx", "rad", "tilt of the axis about x", -0.1, 0.1, 5e-4, _SOURCE, tolerance=_WORST_ANGLE),
        ParameterSpec("ry", "rad", "tilt of the axis about y", -0.1, 0.1, 5e-4, _SOURCE, tolerance=_WORST_ANGLE),
    )
    # of a prismatic joint the tilts alone
    prismatic = parameters[2:]
    needs = ("absolute poses in poses with different angles of every joint",)
    looks_like = ("joint-offset", "joint-eccentricity", "link-springs")
    fingerprint = (
        "the position error is a fixed vector on each link, which rotates with the joints and does not "
        "depend on the load"
    )
    how_to_check = "Move only this joint, unloaded: the circle of the target gives position and tilt of the axis."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Displacements do not depend on it to first order."""
        return lacks_absolute_places(states)

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """N · Trans(x, y, 0) · Exp(rx, ry, 0) in place of N."""
        shift = np.eye(4)
        shift[:2, 3] = values.get("x", 0.0), values.get("y", 0.0)
        shift[:3, :3] = rotation_from_vector(np.array([values.get("rx", 0.0), values.get("ry", 0.0), 0.0]))
        fixed = chain.fixed.copy()
        fixed[place.joints[0] - 1] = fixed[place.joints[0] - 1] @ shift
        return replace(chain, fixed=fixed)

    def geometry_terms(self, place: Place, chain: Chain, angles: Floats, shape: Values) -> Sequence[Term]:
        """The shift's and the tilt's directions in the turned axes of the joint, about the bearing."""
        joint = place.joints[0]
        node, bearing = joint_node(joint), float(chain.bearing[joint - 1])
        if joint in chain.prismatic_joints:
            # the tilts are about the frame's origin at position 0; the bearing is this far out
            one, lever = np.ones(angles.shape[1]), angles[joint - 1] + bearing
            return [
                Term(node, RX, "rx", one), Term(node, TY, "rx", -lever),
                Term(node, RY, "ry", one), Term(node, TX, "ry", lever),
            ]  # fmt: skip
        cosine, sine = np.cos(angles[joint - 1]), np.sin(angles[joint - 1])
        terms = [
            Term(node, TX, "x", cosine), Term(node, TY, "x", -sine),
            Term(node, TX, "y", sine), Term(node, TY, "y", cosine),
            Term(node, RX, "rx", cosine), Term(node, RY, "rx", -sine),
            Term(node, RX, "ry", sine), Term(node, RY, "ry", cosine),
        ]  # fmt: skip
        if bearing:
            # the tilts are about the frame's origin, and the node turns about its bearing
            terms += [
                Term(node, TX, "rx", -bearing * sine), Term(node, TY, "rx", -bearing * cosine),
                Term(node, TX, "ry", bearing * cosine), Term(node, TY, "ry", -bearing * sine),
            ]  # fmt: skip
        return terms
