"""Balancing springs."""

from __future__ import annotations

import copy
from dataclasses import replace

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.abilities import ParallelSpring
from stiffcal.model.balance.stated_spring import spring_at_rate, spring_joint, stated_rate
from stiffcal.model.effect import (
    Covariate,
    Effect,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Values,
)
from stiffcal.model.scalar_laws import BalancingSpring

# A coil spring's rate against the stated one.
USUAL_ERROR = 1.1
_USUAL_ERROR_SOURCE = "coil springs: some 10 % from the stated rate (EN 15800, coarse grade)"
_NO_GEOMETRY = "the compensator's geometry: [gravity_compensator] in robot.toml"


class GravityCompensator(ParallelSpring):
    """A spring or cylinder in parallel with a joint balances weight, adds stiffness and shifts torque.

    Law: F = k (l − l0) and τ_s = −F ∂l/∂q, with F the tension and l(q) the length of a spring that runs from an anchor
    on the link before to an arm on the link moved, and τ_s what it adds to its joint's drive: the drive carries the
    weight's and the load's torque plus τ_s, and −∂τ_s/∂q adds to the joint's stiffness (Klimchik et al. 2013, on heavy
    robots with such springs). The length without tension l0 follows from robot.toml: the preload is what the spring
    pulls with, at its nominal rate, at the joint's zero. A rate that robot.toml states counts without this effect too,
    as masses do; with the effect in the model the rate is estimated, and what it differs by from the stated one is what
    the effect adds.

    Assumes a spring of constant rate without friction, fixed at two points. A gas cylinder is one about its working
    point.

    Limits: its stiffness shows as a joint compliance that varies with the pose; its torque shows only where the
    drive's law is not straight. Without geometry in robot.toml it is not tried; periodic-stiffness of order 1 at that
    joint is then its look-alike.
    """

    name = "gravity-compensator"
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
        return [] if chain.compensator is None else [Place("joints", (spring_joint(chain),))]

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """The geometry."""
        return _NO_GEOMETRY if chain.compensator is None else None

    def balancing_spring(self, place: Place, chain: Chain, values: Values) -> BalancingSpring | None:
        """Return the spring with its free length, from the stated rate and the preload at the joint's zero."""
        return spring_at_rate(chain, values["rate"]) if "rate" in values else None

    def at(self, place: Place, chain: Chain) -> Effect:
        """Return the effect with the rate counted from the one that acts without it: that of robot.toml."""
        rate = stated_rate(chain)
        if rate is None:
            return self
        form = copy.copy(self)
        form.parameters = (  # type: ignore[misc]  # of this instance alone
            replace(self.spec("rate"), neutral=rate, typical=USUAL_ERROR * rate, source=_USUAL_ERROR_SOURCE),
        )
        return form

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The joint's angle."""
        joint = place.joints[0]
        return Covariate(f"angle of joint {joint}", "rad", loads.angles[joint - 1])
