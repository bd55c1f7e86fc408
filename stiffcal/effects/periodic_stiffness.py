"""Compliance that turns with the joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Law,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.drives import drive_law, drive_terms, drive_torque
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

_ORDERS = (1, 2, 3, 4)
_SOURCE = "about ten per cent of a drive's compliance of 2e-6 (Wang, Zhang and Fuhlbrigge 2009, section III.C)"


class PeriodicStiffness(Law):
    """The compliance of a joint varies with its angle, because the load-carrying parts rotate with it.

    Law: δ_Rz = (a cos mq + b sin mq) τ, with q the joint's angle from its zero as the controller shows it (in the
    joint frame's sense of turning), m the order and τ the whole torque. Orders 1 to 4 are tried, and the gear orders
    that robot.toml gives for the joint, no others: a free order finds something in any data.

    Assumes that compliance varies with the joint angle and nothing else. Bearings with uneven seats (order 1, 2),
    gears with two, three or four eccentrics or rollers, and balancing springs of unknown geometry (order 1) do so.

    Limits: twelve poses are twelve angles; two amplitudes besides the joint's mean compliance use them up fast, and an
    order differs from another only where the angles are spread well. |(a, b)| may not exceed the joint's compliance.
    """

    name = "periodic-stiffness"
    place_kind = "joints"
    prismatic = "it has no angle"
    in_drive = True
    summary = "compliance varies with the joint angle"
    parameters = (
        ParameterSpec("a", "rad/(N·m)", "cosine part of the compliance variation", -1e-3, 1e-3, 2e-7, _SOURCE),
        ParameterSpec("b", "rad/(N·m)", "sine part of the compliance variation", -1e-3, 1e-3, 2e-7, _SOURCE),
        ParameterSpec(
            "order", "1", "waves per revolution of the joint", 1.0, 1e4, 2.0,
            "physics of bearings and gears: 1 to 4, else the gear orders in robot.toml",
            ParameterRole.NONLINEAR, discrete=True,
        ),
    )  # fmt: skip
    needs = ("several angles of the joint",)
    looks_like = ("joint-compliance", "gravity-compensator", "bearing-tilt")
    fingerprint = "the compliance of the joint in each pose is a sine of its angle"
    how_to_check = "Load only this joint with the same lever arm at angles 30° apart over its range."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Three angles at least: mean, cosine and sine."""
        if len(np.unique(np.round(np.degrees(states.joints)), axis=0)) < 4:
            return (
                "at least four poses: mean, cosine and sine of the compliance of each joint are already three "
                "parameters"
            )
        return None

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = (a cos mq + b sin mq) τ."""
        joint = place.joints[0]
        phase = shape["order"] * (loads.angles[joint - 1] - chain.offset[joint - 1])
        torque = drive_torque(chain, loads.wrench, joint)
        return (
            *drive_terms(chain, joint, "a", np.cos(phase) * torque),
            *drive_terms(chain, joint, "b", np.sin(phase) * torque),
        )

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """(a cos mq + b sin mq) τ."""
        joint = place.joints[0]
        numbers = values["a"], values["b"], values["order"], float(chain.offset[joint - 1])
        return drive_law(chain, joint, LawForm.PERIODIC, *numbers)

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Orders 1 to 4 and the joint's gear orders."""
        orders = {*_ORDERS, *chain.gear_orders[place.joints[0] - 1]}
        return {"order": np.array(sorted(orders), dtype=np.float64)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The joint's angle."""
        joint = place.joints[0]
        return Covariate(f"angle of joint {joint}", "rad", loads.angles[joint - 1])
