"""Force sensors whose moments refer to another point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Inputs, Instrument, ParameterRole, ParameterSpec, Place, Values

_SOURCE = (
    "origin at the face of the sensor in the data sheet, at its middle in the calibration: ten to thirty millimetres"
)


class WrenchOrigin(Instrument):
    """The reference point of the moments of the force sensor differs from the manifest.

    Law: p_true = p + d and M = M_read + d × F, with p the manifest's origin, M the moment about it, and d = (x, y, z)
    in sensor axes.

    Assumes that the sensor is mounted without play, and that its axes are those of the manifest.

    Limits: an offset along the force has no effect; three directions of load are needed. A joint at a lever of a metre
    gets a moment that is wrong by a per cent for ten millimetres, the wrist with its short levers by ten: the stiffness
    of joints with short lever arms is affected first.
    """

    name = "wrench-origin"
    place_kind = "setup"
    summary = "position of the force sensor origin differs from the manifest"
    parameters = tuple(
        ParameterSpec(
            axis,
            "m",
            f"true minus manifest position along the sensor's {axis} axis",
            -0.5,
            0.5,
            1e-2,
            _SOURCE,
            ParameterRole.SETUP,
        )
        for axis in "xyz"
    )
    needs = ("forces with moments, in several directions",)
    looks_like = ("wrench-scale", "wrench-frame", "target-offset", "tool-compliance")
    fingerprint = "the rotation of the wrist differs from that of the measured moments, in proportion to the force"
    how_to_check = (
        "Hang a known mass on a hook at a known position and compare the measured moment with lever arm times "
        "weight, in two orientations of the flange; or look up the origin in the data sheet of the sensor."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Moments must be read."""
        if not states.setup.moments_measured:
            return "forces with moments: here forces alone are measured, and load-point-offset is the same error"
        return None

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Move the point that the moments refer to."""
        offset = np.array([values.get(axis, 0.0) for axis in "xyz"])
        setup = inputs.setup
        if not offset.any() or not setup.moments_measured:
            return inputs
        point = setup.wrench_point
        # Readings in axes of another body (the base's) carry none of the sensor's: the point's own axes are taken.
        axes = setup.wrench_axes if setup.wrench_axes.body == point.body else point
        transform = point.transform.copy()
        transform[:3, 3] += axes.transform[:3, :3] @ offset
        return replace(inputs, setup=replace(setup, wrench_point=replace(point, transform=transform)))
