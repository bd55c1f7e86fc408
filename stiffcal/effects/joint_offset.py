"""Joints whose zero is not where the robot file has it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.absolute_places_needed import lacks_absolute_places
from stiffcal.model.effect import Geometry, ParameterSpec, Place, Term, Values, joint_node

_ALONG_AXIS = ParameterSpec(
    "zero", "m", "offset added to the logged position", -0.2, 0.2, 1e-3,
    "referencing of linear axes: the switch is placed to a millimetre", tolerance=5e-3,
)  # fmt: skip


class JointOffset(Geometry):
    """The zero of a joint differs from the robot file; the value is the offset to enter in the controller.

    Law: q = q_read + zero, with q_read the logged angle of the joint, before ``direction`` and ``logged = {…}``; the
    model angles that are combinations of it follow.

    Assumes that the whole scale is shifted, as after a lost or changed encoder.

    Limits: together with the geometry of all links it is redundant (``link-geometry`` replaces it). The first joint's
    zero cannot be separated from a tracker that is estimated, the last one's not from a target that is.

    Of a prismatic joint the zero is a length.
    """

    name = "joint-offset"
    place_kind = "joints"
    summary = "zero offset of a joint against the robot file"
    parameters = (
        ParameterSpec(
            "zero", "rad", "offset added to the logged angle", -0.2, 0.2, 1e-3,
            "zeros (mastering) of industrial robots: about a milliradian", tolerance=5e-3,
        ),
    )  # fmt: skip
    # of a prismatic joint a length
    prismatic = (_ALONG_AXIS,)
    needs = ("absolute poses in poses with different joint angles",)
    looks_like = ("link-geometry", "joint-eccentricity")
    fingerprint = "the position error is proportional to the lever arm about one joint axis, the same at all its angles"
    how_to_check = (
        "Move the joint to its mechanical reference mark and compare with the angle that the controller shows."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Displacements do not depend on it to first order."""
        return lacks_absolute_places(states)

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """Turn, or shift, every joint frame whose model angle takes the logged one."""
        zero = values.get("zero", 0.0)
        if not zero:
            return chain
        fixed = chain.fixed.copy()
        for model_joint, share in enumerate(chain.coupling[:, place.joints[0] - 1]):
            moved = np.eye(4)
            if chain.prismatic[model_joint]:
                moved[2, 3] = share * zero
            else:
                cosine, sine = np.cos(share * zero), np.sin(share * zero)
                moved[:2, :2] = [[cosine, -sine], [sine, cosine]]
            fixed[model_joint] = fixed[model_joint] @ moved
        return replace(chain, fixed=fixed)

    def geometry_terms(self, place: Place, chain: Chain, angles: Floats, shape: Values) -> Sequence[Term]:
        """A turn about the axis, or a shift along it, of every joint whose model angle takes the logged one."""
        return [
            Term(
                joint_node(model_joint + 1),
                int(chain.drive_components[model_joint]),
                "zero",
                np.full(angles.shape[1], share),
            )
            for model_joint, share in enumerate(chain.coupling[:, place.joints[0] - 1])
            if share
        ]
