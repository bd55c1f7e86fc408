"""Reflectors that are not where the manifest states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Inputs, Instrument, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "position of a reflector measured with a ruler: one or two millimetres"


class TargetOffset(Instrument):
    """The position of the reflector or probe differs from the manifest, so a rotation of the tool moves it differently.

    Law: p_true = p + (x, y, z), with p the target's place on the flange of the manifest, in flange axes; where several
    targets sit on the flange, all of them (one tool, one error). Targets on links stay.

    Assumes that the target does not move against the flange.

    Limits: a displacement differs by the rotation of the tool times the offset: 1 mrad and 1 mm make 1 µm. The unloaded
    poses show it much more clearly, as an error of absolute position.
    """

    name = "target-offset"
    place_kind = "setup"
    summary = "position of the reflector differs from the manifest"
    parameters = tuple(
        ParameterSpec(
            axis,
            "m",
            f"true minus manifest position along the flange's {axis} axis",
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
    fingerprint = "the residual is proportional to the rotation of the tool under load"
    how_to_check = (
        "Rotate the last joint by a full revolution, unloaded: the circle of the reflector shows its offset from the "
        "axis."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """A target must ride on the flange."""
        if all(target.body != chain.n_joints + 1 for target in states.setup.targets):
            return "a target on the flange: all targets sit on links"
        if states.absolute.any() and set(states.setup.target_names) <= set(states.setup.estimated):
            return "a target whose position the manifest gives: those with estimate = true are estimated by the fit"
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
