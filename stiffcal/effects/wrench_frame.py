"""Force sensors that are turned against the flange."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.effect import Inputs, Instrument, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "half a degree: a sensor bolted on without a dowel"


class WrenchFrame(Instrument):
    """The axes of the force sensor are rotated relative to the manifest, so every wrench is rotated.

    Law: R_true = R exp(r), with R the sensor's axes of the manifest and r = (rx, ry, rz) a rotation vector in sensor
    axes; forces and moments rotate together, the origin of the sensor is unchanged.

    Assumes that the sensor does not shift on its seat during the campaign.

    Limits: a rotation about the direction of the load has no effect: three directions of load are needed. Its effect is
    as large as the deflection times the angle, of the other components of compliance.
    """

    name = "wrench-frame"
    place_kind = "setup"
    summary = "rotation error between force sensor and flange"
    parameters = tuple(
        ParameterSpec(
            f"r{axis}", "rad", f"rotation about the sensor {axis} axis", -0.5, 0.5, 0.01, _SOURCE, ParameterRole.SETUP
        )
        for axis in "xyz"
    )
    looks_like = ("tracker-frame", "load-point-offset", "axis-coupling")
    needs = ("loads in several directions",)
    fingerprint = "the residual is that of a small force perpendicular to the load, in proportion to the load"
    how_to_check = "Hang a known mass on the tool in several poses: the measured force must always point along gravity."

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Turn the axes in which the wrench is read."""
        turn = np.array([values.get(f"r{axis}", 0.0) for axis in "xyz"])
        if not turn.any():
            return inputs
        axes = inputs.setup.wrench_axes
        transform = axes.transform.copy()
        transform[:3, :3] = transform[:3, :3] @ rotation_from_vector(turn)
        return replace(inputs, setup=replace(inputs.setup, wrench_axes=replace(axes, transform=transform)))
