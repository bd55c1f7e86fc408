"""Force sensors whose moments refer to another point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import DocumentedEffect, Inputs, Kind, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "the data sheet's origin at the sensor's face, the calibration's at its middle: ten to thirty millimetres"


class WrenchOrigin(DocumentedEffect):
    """The point to which the force sensor's moments refer is not where the manifest states.

    Law: p_true = p + d and M = M_read + d × F, with p the manifest's origin, M the moment about it, and d = (x, y, z)
    in sensor axes.

    Assumes that the sensor sits on its seat without play, and that its axes are those of the manifest.

    Limits: an offset along the force does nothing; three directions of load are needed. A joint at a lever of a metre
    gets a moment that is wrong by a per cent for ten millimetres, the wrist with its short levers by ten: of joints
    that the load turns through short levers the stiffness is wrong first.
    """

    name = "wrench-origin"
    kind = Kind.OBSERVATION
    place_kind = "setup"
    summary = "the force sensor's origin is not where the manifest puts it"
    parameters = tuple(
        ParameterSpec(
            axis,
            "m",
            f"true minus manifest along the sensor's {axis} axis",
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
    fingerprint = "the wrist turns by more or less than the moments read say, in proportion to the force"
    how_to_check = (
        "Hang a known mass on a hook of known place and compare the moment read with lever times weight, in two "
        "orientations of the flange; or look up in the sensor's data sheet where its origin lies."
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
