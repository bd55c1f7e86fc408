"""Balancing springs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    DocumentedEffect,
    Kind,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Values,
)
from stiffcal.model.scalar_laws import BalancingSpring

_NO_GEOMETRY = "the compensator's geometry: [gravity_compensator] in robot.toml"


class GravityCompensator(DocumentedEffect):
    """A spring or cylinder in parallel with a joint balances weight, adds stiffness and shifts torque.

    Law: F = k (l − l0) and τ_s = −F ∂l/∂q, with F the tension and l(q) the length of a spring that runs from an anchor
    on the link before to an arm on the link moved, and τ_s what it adds to its joint's drive: the drive carries the
    weight's and the load's torque plus τ_s, and −∂τ_s/∂q adds to the joint's stiffness (Klimchik et al. 2013, on heavy
    robots with such springs). The length without tension l0 follows from robot.toml: the preload is what the spring
    pulls with, at its nominal rate, at the joint's zero.

    Assumes a spring of constant rate without friction, fixed at two points. A gas cylinder is one about its working
    point.

    Limits: its stiffness shows as a joint compliance that varies with the pose; its torque shows only where the
    drive's law is not straight. Without geometry in robot.toml it is not tried; periodic-stiffness of order 1 at that
    joint is then its look-alike.
    """

    name = "gravity-compensator"
    kind = Kind.CONFIGURATION
    place_kind = "joints"
    summary = "balancing spring or cylinder of a joint, with its geometry in robot.toml"
    parameters = (
        ParameterSpec(
            "rate", "N/m", "spring rate of the balancing spring", 0.0, 1e8, 1e5,
            "a balancer of the 200 kg class: some 10 kN over a stroke of 0.1 m; robot manufacturers publish no values",
            ParameterRole.SETUP,
        ),
    )  # fmt: skip
    needs = ("the compensator's geometry in robot.toml",)
    looks_like = ("periodic-stiffness", "joint-compliance")
    fingerprint = "the compliance of the joint depends on the lever arm of the balancing spring in each pose"
    how_to_check = (
        "Measure the joint's motor current in free motion over its range, with and without the spring's preload."
    )

    def places(self, chain: Chain) -> list[Place]:
        """Return the compensated joint, where robot.toml gives its geometry."""
        return [] if chain.compensator is None else [Place("joints", (_joint(chain),))]

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """The geometry."""
        return _NO_GEOMETRY if chain.compensator is None else None

    def joint_torque(self, place: Place, chain: Chain, angles: Floats, values: Values) -> Floats | None:
        """Return τ_s = −k (l − l0) ∂l/∂q at the joint's angle, its give included."""
        spring = self.balancing_spring(place, chain, values)
        return None if spring is None else spring.torque(angles[spring.joint - 1])

    def balancing_spring(self, place: Place, chain: Chain, values: Values) -> BalancingSpring | None:
        """Return the spring with its free length, from the nominal rate and the preload at the joint's zero."""
        rate = values.get("rate", 0.0)
        if rate == 0.0 or chain.compensator is None:
            return None
        joint = place.joints[0]
        fixed, arm = chain.fixed[joint - 1], _point(chain, "arm_m")
        # In the joint's frame before it turns, whose z is the joint's axis.
        anchor = fixed[:3, :3].T @ (_point(chain, "anchor_m") - fixed[:3, 3])
        nominal = chain.compensator.get("rate_N_m")
        preload = chain.compensator.get("preload_N") or 0.0
        stretched = 0.0 if nominal is None else float(str(preload)) / float(str(nominal))
        untensed = BalancingSpring(joint, _three(anchor), _three(arm), rate, 0.0)
        return replace(untensed, free_length=float(untensed.length(chain.offset[joint - 1])) - stretched)

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The joint's angle."""
        joint = place.joints[0]
        return Covariate(f"angle of joint {joint}", "rad", loads.angles[joint - 1])


def _joint(chain: Chain) -> int:
    return int(str((chain.compensator or {})["joint"]))


def _point(chain: Chain, key: str) -> Floats:
    return np.asarray((chain.compensator or {})[key], dtype=np.float64)


def _three(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
