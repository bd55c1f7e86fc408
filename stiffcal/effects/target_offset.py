"""Reflectors that are not where the manifest states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import DocumentedEffect, Inputs, Kind, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "a reflector's place measured with a ruler: a millimetre or two"


class TargetOffset(DocumentedEffect):
    """The reflector or probe is not where the manifest states, so that the turning of the tool moves it otherwise.

    Law: p_true = p + (x, y, z), with p the target's place on the flange of the manifest, in flange axes; where several
    targets sit on the flange, all of them (one tool, one error). Targets on links stay.

    Assumes that the target does not move against the flange.

    Limits: a displacement differs by the tool's turn times the offset: a millirad of turn and a millimetre of offset
    make one micrometre. It shows in the unloaded poses long before, as an error of absolute position.
    """

    name = "target-offset"
    kind = Kind.OBSERVATION
    place_kind = "setup"
    summary = "the reflector is not where the manifest puts it"
    parameters = tuple(
        ParameterSpec(
            axis,
            "m",
            f"true minus manifest along the flange's {axis} axis",
            -0.5,
            0.5,
            2e-3,
            _SOURCE,
            ParameterRole.SETUP,
        )
        for axis in "xyz"
    )
    needs = ("a target on the flange",)
    looks_like = ("load-point-offset", "tool-compliance")
    fingerprint = "the residual is in proportion to how much the tool turns under load"
    how_to_check = (
        "Turn the last joint through a full turn, unloaded: the reflector's circle shows its offset from the axis."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """A target must ride on the flange."""
        if all(target.body != chain.n_joints + 1 for target in states.setup.targets):
            return "a target on the flange: all targets sit on links"
        if states.absolute.any() and set(states.setup.target_names) <= set(states.setup.estimated):
            return "a target whose place the manifest gives: those with estimate = true are found by the fit"
        return None

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Move the targets on the flange."""
        offset = np.array([values.get(axis, 0.0) for axis in "xyz"])
        if not offset.any():
            return inputs
        flange = len(inputs.angles) + 1
        targets = []
        for target in inputs.setup.targets:
            transform = target.transform.copy()
            transform[:3, 3] += offset
            targets.append(replace(target, transform=transform) if target.body == flange else target)
        return replace(inputs, setup=replace(inputs.setup, targets=tuple(targets)))
