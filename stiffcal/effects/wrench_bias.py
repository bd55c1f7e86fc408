"""Force sensors that do not read zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Inputs, Instrument, ParameterRole, ParameterSpec, Place, Values

_SYMBOLS = ("fx", "fy", "fz", "mx", "my", "mz")
_BIAS = "one per cent of a sensor range of 10² N and 10 N·m: drift since the last taring"
# Joints that turn by this much within a run bring the sensor into another orientation.
_TURNED = np.radians(5.0)
# A net mass that is exactly zero has no centre: one this small carries the moment and no weight worth the name.
_TINY_MASS = 1e-9


def _bias(symbol: str) -> ParameterSpec:
    unit, widest, typical = ("N", 1e3, 2.0) if symbol[0] == "f" else ("N·m", 300.0, 0.2)
    meaning = f"bias of {symbol.capitalize()}, sensor axes"
    return ParameterSpec(symbol, unit, meaning, -widest, widest, typical, _BIAS, ParameterRole.SETUP)


class WrenchBias(Instrument):
    """The zero offset of the force sensor, or the weight of the tool beyond it, is still in the readings.

    Law: w = w_read − (fx, fy, fz, mx, my, mz) − w_tool, with w_read the reading; the bias is constant in sensor axes,
    w_tool is the weight of `mass` along gravity through the sensor's origin.

    Assumes one zero for the whole campaign. Where the weight that the sensor reads belongs to a tool that the manifest
    lists in [tool], mass is what it counts twice.

    Limits: in a run of one pose a constant wrench goes into the run's reference, so that it shows only through laws
    that are not straight (backlash, friction, curved stiffness), or where the sensor turns within a run, or where
    deflections come without a free reference. Elsewhere it is not tried.
    """

    name = "wrench-bias"
    place_kind = "setup"
    summary = "uncompensated zero offset of the force sensor or weight of the tool"
    parameters = (
        *(_bias(symbol) for symbol in _SYMBOLS),
        ParameterSpec(
            "mass", "kg", "mass whose weight is included in the reading", -500.0, 500.0, 5.0,
            "tools of robots for machining: a spindle or gripper of some kilograms", ParameterRole.SETUP,
        ),
    )  # fmt: skip
    needs = ("several orientations of the sensor within a run, or deflections without a free reference",)
    looks_like = ("target-offset", "wrench-frame", "backlash")
    fingerprint = "the deflection is that of a constant force, fixed to the sensor (bias) or vertical (weight)"
    how_to_check = (
        "Read the unloaded sensor in three orientations of the flange: the part fixed to the sensor is bias, the "
        "rest is weight."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Several orientations within a run, or no free reference."""
        if states.deflection_given:
            return None
        if len(states) and states.absolute.all():
            return "load runs: in absolute poses alone a bias acts like other masses, compliances and geometry"
        for members in members_of(states.run):
            if float(np.ptp(states.joints[members], axis=0).max()) > _TURNED:
                return None
        return (
            "several orientations in a run: the joints do not move, so a bias is included in the reference of each run"
        )

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Take bias and weight out of the reading; the weight-only state has no reading."""
        if not inputs.loaded:
            return inputs
        bias = np.array([values.get(symbol, 0.0) for symbol in _SYMBOLS])
        if bias.any():
            read = True if inputs.read is None else inputs.read
            inputs = replace(inputs, wrench=inputs.wrench - np.where(read, bias[:, None], 0.0))
        mass, point = values.get("mass", 0.0), inputs.setup.wrench_point
        if mass == 0.0 or point.body != len(inputs.angles) + 1:
            return inputs
        setup = inputs.setup
        remaining_mass = setup.tool_mass - mass
        remaining_mass = remaining_mass if abs(remaining_mass) > _TINY_MASS else _TINY_MASS
        centre = (setup.tool_mass * setup.tool_com - mass * point.transform[:3, 3]) / remaining_mass
        return replace(inputs, setup=replace(setup, tool_mass=remaining_mass, tool_com=centre))
