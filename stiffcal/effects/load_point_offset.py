"""Forces that act elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Inputs, Instrument, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "a hook or the knot of a rope measured with a ruler: a few millimetres"


class LoadPointOffset(Instrument):
    """The point of load application differs from the manifest, so the moments about the joints are wrong.

    Law: p_true = p + (x, y, z), with p the load point of the manifest, in flange axes. Only where force alone is
    measured: a six-axis sensor reads the moment and needs no load point.

    Assumes one load point for the whole campaign, fixed to the flange.

    Limits: an offset along the force has no effect; three directions of load are needed. An offset of a millimetre at a
    lever of a metre changes that joint's deflection by a thousandth: the wrist, with its short levers, shows more.
    """

    name = "load-point-offset"
    place_kind = "setup"
    summary = "point of load application differs from the manifest (campaigns with forces only)"
    parameters = tuple(
        ParameterSpec(
            axis,
            "m",
            f"true minus manifest position along the flange's {axis} axis",
            -0.5,
            0.5,
            5e-3,
            _SOURCE,
            ParameterRole.SETUP,
        )
        for axis in "xyz"
    )
    needs = ("forces without moments, acting on the flange",)
    looks_like = ("target-offset", "wrench-frame", "joint-compliance")
    fingerprint = "the rotation of the wrist differs from that of the stated lever arm, in proportion to the load"
    how_to_check = "Measure the load point with the tracker: place a reflector on the hook."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Only for forces without moments, on the flange."""
        if states.setup.moments_measured:
            return "forces without moments: here the moments are measured, so no load point is needed"
        if states.setup.wrench_point.body != chain.n_joints + 1:
            return "a load that acts on the flange"
        return None

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Move the point where the force acts."""
        offset = np.array([values.get(axis, 0.0) for axis in "xyz"])
        point = inputs.setup.wrench_point
        if not offset.any() or inputs.setup.moments_measured or point.body != len(inputs.angles) + 1:
            return inputs
        transform = point.transform.copy()
        transform[:3, 3] += offset
        return replace(inputs, setup=replace(inputs.setup, wrench_point=replace(point, transform=transform)))
