"""Friction that lets loading and unloading run apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats, Integers
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
from stiffcal.model.forms import MotorFriction
from stiffcal.model.laws.drives import drive_covariate, drive_law, drive_terms, drive_torque
from stiffcal.model.laws.memory import clamped_between, first_of_run, play_operator, play_operator_from_rest
from stiffcal.model.laws.prismatic import specs_along_axis
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

# Slips tried, as shares of the largest swing of torque within one run: a slip beyond half the swing never lets go.
_SLIPS = np.geomspace(0.02, 0.45, 7)
# An angle that changes by less than this share of its range stays: what rounding leaves of a play operator.
_STILL = 1e-9


class FrictionHysteresis(Law):
    """A part of the drive is held by dry friction: it follows the torque only after the torque has reversed far enough.

    Law: δ_Rz = c P_r[τ], P_r the play operator: its value is constant until it lags the torque by r (slip), then
    follows at that distance, P_i = min(max(P_{i−1}, τ_i − r), τ_i + r) (Brokate and Sprekels 1996, section 2.3; a
    spring in parallel with a slider, the element of Ruderman, Hoffmann and Bertram 2009). τ is the whole torque, states
    in the order in which they were reached; the memory is zero at the run's start, then the weight acts, then the
    states.

    Assumes dry friction that does not depend on speed or time, and that all turning points of the load are among the
    load states. Several elements with different slips add up to any symmetric loop; one is fitted.

    In absolute runs whose table states the direction s of each drive's last motion, +1 or −1, the drive has slipped
    through by then, and P_r[τ] = τ − r s. Of that, c τ is the drive's compliance; what is left is the form [width],
    δ_Rz = −(width/2) s, the width 2 c r: the reversal error of ISO 230-2, of an axis that comes to rest on the side
    from which it was moved. Backlash that friction keeps on that side displaces alike.

    Limits: the history of the joint before the run is unknown; the first half cycle is therefore less certain than
    later ones. Load that only grows shows no loop.

    Where the load of clamped runs is the motor's torque, friction between motor and spring reduces it. The form
    [coulomb per_Nm] is that law: the torque s of the spring stays until the motor's differs from it by coulomb + per_Nm
    |s|, then follows at that distance (the generalised play operator, Visintin 1994, section III.2; friction that grows
    with the load: Bittencourt and Gunnarsson 2012). All laws of the drive act on s: compliance, play and curve are
    those of the spring. joint-friction and friction-load hold the same two for a moving joint. A wrong torque constant
    changes coulomb and all stiffnesses by one factor, and cannot be distinguished from them. An error of the torque at
    a turning point is shared by all states up to the next motion; the uncertainties of this form leave that out and are
    too small, by up to ten times on a simulated bench with 0.05 N·m of noise.
    """

    name = "friction-hysteresis"
    place_kind = "joints"
    in_drive = True
    summary = "loading and unloading follow different curves"
    has_memory = True
    parameters: ClassVar[tuple[ParameterSpec, ...]] = (
        ParameterSpec(
            "c", "rad/(N·m)", "compliance of the slipping part", 0.0, 1e-1, 1e-6,
            "hysteresis loss of 1 arc minute (2 c slip), the usual limit in catalogues of strain-wave gears",
        ),
        ParameterSpec(
            "slip", "N·m", "torque at which the part slips", 1e-2, 1e5, 150.0,
            "as c: 1 arc minute; as the friction torque of a loaded robot joint (Lehmann et al. 2013, section 3.2)",
            ParameterRole.NONLINEAR, meaning_along="force at which the part slips",
        ),
    )  # fmt: skip
    prismatic = specs_along_axis(parameters)
    needs = ("loading and unloading in one run",)
    looks_like: ClassVar[tuple[str, ...]] = ("backlash", "creep", "two-slope")
    fingerprint = "loading and unloading follow different curves, by the same amount in every cycle, at any rate"
    how_to_check = (
        "Repeat loading and unloading with twice the waiting time: with creep the loop closes, with friction it stays."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """A path: runs of a single state have none; of absolute places c and slip have no separate effect."""
        if states.absolute.all():
            return (
                "the order of approach: columns of the direction of each joint's last motion (approach of joints), or "
                'approach = "direct" in [[runs]] where the robot went from row to row'
            )
        if np.bincount(states.run).max(initial=0) >= 3 or _moved_both_ways(states):
            return None
        return "loading and unloading in one run: every run has only one or two states"

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c P_r[τ]."""
        joint, slip = place.joints[0], shape["slip"]
        torque = drive_torque(chain, loads.wrench, joint)
        if loads.order is None:
            return drive_terms(chain, joint, "c", play_operator_from_rest(torque, slip))
        start = None if loads.weight is None else drive_torque(chain, loads.weight, joint)
        direction = loads.order.direction(joint)
        follows = play_operator(torque, slip, loads.order.run, start)
        return drive_terms(chain, joint, "c", np.where(direction != 0.0, torque - slip * direction, follows))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """C P_r[τ]."""
        return drive_law(chain, place.joints[0], LawForm.PLAY, values["c"], values["slip"])

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Slips as shares of the largest swing of torque within one run."""
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        if loads.order is None or torque.size == 0:
            return {"slip": np.zeros(0)}
        _, number = np.unique(loads.order.run, return_inverse=True)
        high, low = np.full(number.max() + 1, -np.inf), np.full(number.max() + 1, np.inf)
        np.maximum.at(high, number, torque)
        np.minimum.at(low, number, torque)
        swing = float((high - low).max())
        return {"slip": np.clip(_SLIPS * swing, 1e-2, 1e5) if swing > 0.0 else np.zeros(0)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis; the residual runs in loops over it."""
        return drive_covariate(chain, loads.wrench, place.joints[0])


class _BeforeSpring(FrictionHysteresis, MotorFriction):
    __doc__ = FrictionHysteresis.__doc__

    parameters = (
        ParameterSpec(
            "coulomb", "N·m", "friction between motor and spring without load", 0.0, 1e5, 5.0,
            "1.9 to 9.6 N·m, published for three printed reducers (JelmerV, Anti-Backlash-Cycloidal-Actuator)",
            ParameterRole.SETUP,
        ),
        ParameterSpec(
            "per_Nm", "1", "friction between motor and spring per torque of the spring", 0.0, 0.9, 0.05,
            "a few per cent of the load torque (Bittencourt and Gunnarsson 2012, experiments on an ABB IRB 6620)",
            ParameterRole.SETUP,
        ),
    )  # fmt: skip
    prismatic = specs_along_axis(parameters)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Nothing of its own: it changes the torque on which the drive's other laws act."""
        return ()

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """None: a load at the tool acts on the spring from its other side."""
        return ()

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """No shape parameters."""
        return {}

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Loads that are the torques of clamped motors, all of them."""
        motors = len(states) and all(run.motor_torque for run in states.runs)
        return None if motors else "clamped runs with the motor's torque, and no others"

    def start(self, torque: Floats, angle: Floats) -> dict[str, float]:
        """Return half the largest swing of torque during which the angle stays."""
        if not angle.any():
            return {"coulomb": 0.0, "per_Nm": 0.0}
        moves = np.flatnonzero(np.abs(np.diff(angle)) > _STILL * np.ptp(angle)) + 1
        swings = [float(np.ptp(piece)) for piece in np.split(torque, moves)]
        return {"coulomb": 0.5 * max(swings), "per_Nm": 0.0}

    def spring_torque(
        self, place: Place, torque: Floats, run: Integers, weight: Floats | None, values: Values
    ) -> Floats | None:
        """Return s, the torque behind the friction; a run begins with the weight alone on the spring."""
        coulomb, share = values.get("coulomb", 0.0), values.get("per_Nm", 0.0)
        if coulomb == 0.0 and share == 0.0:
            return None
        lower, upper = _behind(torque, coulomb, share), -_behind(-torque, coulomb, share)
        first = first_of_run(run)
        return clamped_between(lower, upper, run, np.zeros(int(first.sum())) if weight is None else weight[first])


def _behind(torque: Floats, coulomb: float, share: float) -> Floats:
    """Return (n,) s with s + coulomb + share |s| = torque: the least torque on the spring at a motor's torque, N·m."""
    remaining = torque - coulomb
    return np.where(remaining > 0.0, remaining / (1.0 + share), remaining / (1.0 - share))


def _moved_both_ways(states: LoadStates) -> bool:
    """Return whether a drive's last motion is known and was in both directions."""
    return bool(((states.approach > 0.0).any(axis=0) & (states.approach < 0.0).any(axis=0)).any())


class _AfterMotion(FrictionHysteresis):
    __doc__ = FrictionHysteresis.__doc__

    parameters = (
        ParameterSpec(
            "width", "rad", "distance between the rests after motion one way and the other", 0.0, 0.1, 2.9e-4,
            "1 arc minute, the usual limit of the hysteresis loss in catalogues of strain-wave gears", reversal=True,
        ),
    )  # fmt: skip
    prismatic = specs_along_axis(parameters)
    summary = "a joint comes to rest on the side from which it was moved"
    looks_like = ("backlash", "joint-eccentricity")
    fingerprint = "the residual depends on the direction in which the joint moved last, and on nothing else"
    how_to_check = (
        "Move the joint to the same pose from both sides, with all other joints at rest: the two places differ by the "
        "width times the distance from the joint's axis."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Places alone, with the direction of each drive's last motion, both ways."""
        places = len(states) and states.absolute.all() and _moved_both_ways(states)
        return None if places else "absolute runs alone, with the direction of each joint's last motion"

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = −(width/2) s; where no direction is known, and under weight alone, none."""
        joint = place.joints[0]
        return drive_terms(chain, joint, "width", -0.5 * _direction(loads, joint))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """None: it does not follow the load."""
        return ()

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """No shape parameters."""
        return {}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The direction of the joint's last motion."""
        joint = place.joints[0]
        return Covariate(f"direction of the last motion of joint {joint}", "1", _direction(loads, joint))


def _direction(loads: NodeLoads, joint: int) -> Floats:
    return np.zeros(loads.angles.shape[1]) if loads.order is None else loads.order.direction(joint)


FrictionHysteresis.forms = (FrictionHysteresis(), _BeforeSpring(), _AfterMotion())
