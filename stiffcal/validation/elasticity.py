"""Whether absolute poses show that the joints give: what weight turns looks much like an error of the joint's angle.

Under its own weight an upright arm turns a joint by c τ(q), and τ contains cos(q + φ): an encoder that runs out by one
wave a turn gives the same places wherever the other joints stand alike. Waves of several joints together do so over a
wider range of poses. A compliance is claimed only where the error in regions left out falls with it, next to that wave
of its joint too, and next to those of all joints; and where its value is above zero by more than chance.

An effect that is missing in the model is no noise: what it leaves is alike in poses near each other, so that the
standard error of independent rows is too small. A law of the joint holds in every region of the joints' ranges alike,
and what mimics it in one does not in the next. So the value has to be above zero against its scatter between regions
left out as well: the jackknife over groups, with Student's distribution for as many groups (MacKinnon, Nielsen and
Webb, Journal of Econometrics 232, 2023, CV3 and section 3.2, `cluster-robust inference`).
Of the error in regions left out the sign is asked: a parameter that is none raises it on average, as it is fitted
elsewhere. Six differences that one region may decide have no standard error of use, and that over poses counts what a
region's poses share as if each had it by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.parameters import Parameter
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.fitting.load_scale import common_scale
from stiffcal.identification.readings.row_layout import TRANSLATION
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.kinematics import stacked_bodies
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from stiffcal.validation.distances import squared_distances
from stiffcal.validation.elasticity_results import Elasticity, ElasticityVerdict, JointElasticity, JointVerdict
from stiffcal.validation.heldout import estimates_without_each, left_out_residuals
from stiffcal.validation.region_folds import region_folds
from stiffcal.wording import significant

ERRORS = 2.0
"""Standard deviations by which a compliance is above zero."""
KNOWN = 5.0
"""Standard deviations from zero at which a payload is to show a compliance: 20 %."""
LEAST_LEVER = 0.01
"""Share of the arm's longest lever below which weight at the flange does not turn a joint."""
LEAST_PAYLOAD = 0.02
"""Share of the rated payload that is worth hanging on: less is within what a flange and its cables weigh."""

_REASONS: dict[JointVerdict, str] = {
    "identified": "the error in held-out regions decreases with it, also with eccentricities of all joints in the "
    "model",
    "unknown-scale": "only weight acts on it, and a common scale of the link moments is unknown",
    "no-torque": "weight produces no torque there in these poses",
    "not-above-zero": "its compliance is less than two standard deviations above zero",
    "error-not-lower": "the error in held-out regions does not decrease with it",
    "like-eccentricity": "eccentricities of joints explain the same places",
    "differs-by-region": "the compliance depends too much on the region of the poses from which it is estimated",
}


def elasticity_of(states: LoadStates, fit: Fit) -> Elasticity | None:
    """Return whether places show that joints give; None where the model contains no such joint.

    None as well where no place was measured, and where runs with loads show it better than weight does.

    Parameters
    ----------
    states : the campaign's absolute poses.
    fit : of the present model.
    """
    own = [
        parameter
        for parameter in fit.parameters
        if parameter.spec.compliance
        and len(parameter.place.joints) == 1
        and parameter.spec.along == fit.robot.chain.drive_components[parameter.place.joints[0] - 1]
        and not parameter.fixed
    ]
    if not own or not len(fit.data.absolute) or not fit.data.absolute.all():
        return None
    judge = _Judge(states, fit)
    verdicts = [(parameter, judge.verdict(parameter)) for parameter in own]
    joints = [
        JointElasticity(
            joint=parameter.place.joints[0],
            verdict=verdict,
            why=_REASONS[verdict],
            payload_kg=None
            if verdict == "identified"
            else payload_that_shows(fit, parameter.place.joints[0], expected_compliance(parameter, fit)),
        )
        for parameter, verdict in verdicts
    ]
    return _summary(joints)


def _summary(joints: list[JointElasticity]) -> Elasticity:
    identified = [joint.joint for joint in joints if joint.verdict == "identified"]
    verdict: ElasticityVerdict = (
        "identified" if len(identified) == len(joints) else "partly-identified" if identified else "not-identified"
    )
    payloads = sorted((joint.payload_kg, joint.joint) for joint in joints if joint.payload_kg is not None)
    payload = payloads[0][0] if payloads else None
    if verdict == "identified":
        return Elasticity(
            verdict=verdict, why="the compliance of every joint is identified", payload_kg=None, joints=joints
        )
    others = [joint.joint for joint in joints if joint.verdict != "identified"]
    known = f"elasticity of {_joints(identified)} is identified; " if identified else ""
    mend = "no payload that the robot can carry would change that"
    if payloads:
        ways = [f"{significant(mass, 2)} kg for joint {joint}" for mass, joint in payloads]
        mend = f"measure again with a payload at the flange in half of the poses: {', '.join(ways)}"
    why = f"{known}elasticity of {_joints(others)} cannot be identified from these poses: {mend}"
    return Elasticity(verdict=verdict, why=why, payload_kg=payload, joints=joints)


def _joints(numbers: list[int]) -> str:
    return f"{'joint' if len(numbers) == 1 else 'joints'} {', '.join(map(str, numbers))}"


class _Judge:
    """Refits of one campaign's places, each judged in the same regions."""

    def __init__(self, states: LoadStates, fit: Fit) -> None:
        self.states, self.fit = states, fit
        self.folds: Integers = region_folds(fit.data)
        self.n_regions = len(np.unique(self.folds))
        self.settings = Settings(noise=fit.noise, fixed=fit.fixed)
        self.present = self._squares(fit)
        self.waves: dict[tuple[int, ...], tuple[Fit, Floats]] = {}
        self.of_unknown_scale = frozenset(common_scale(fit.robot, fit.data, fit.fixed))

    def verdict(self, parameter: Parameter) -> JointVerdict:
        """Judge one joint's compliance."""
        if parameter.name in self.of_unknown_scale:
            return "unknown-scale"
        if parameter.value is None:
            return "no-torque"
        if not _above_zero(parameter, self.fit):
            return "not-above-zero"
        if not self._falls(parameter, self.fit, self.present):
            return "error-not-lower"
        own, everywhere = parameter.place.joints, tuple(range(1, self.fit.robot.chain.n_joints + 1))
        if not (self._survives(parameter, own) and self._survives(parameter, everywhere)):
            return "like-eccentricity"
        fits = (self.fit, self._next_to_waves(own)[0], self._next_to_waves(everywhere)[0])
        return "identified" if all(self._holds_in_regions(parameter, fit) for fit in fits) else "differs-by-region"

    def _survives(self, parameter: Parameter, joints: tuple[int, ...]) -> bool:
        """Return whether a compliance is above zero, and the error falls with it, next to waves of these joints."""
        both, squares = self._next_to_waves(joints)
        again = _again(parameter, both)
        return _above_zero(again, both) and self._falls(again, both, squares)

    def _next_to_waves(self, joints: tuple[int, ...]) -> tuple[Fit, Floats]:
        """Return the fit with eccentricities of order 1 at these joints, and its squared distances (n,)."""
        if joints not in self.waves:
            robot = _with_waves(self.fit.robot, joints)
            fit = self.fit if robot is self.fit.robot else self._refit(robot)
            self.waves[joints] = fit, self._squares(fit)
        return self.waves[joints]

    def _holds_in_regions(self, parameter: Parameter, fit: Fit) -> bool:
        """Return whether a value of a fit is above zero against its scatter between regions left out."""
        value = _again(parameter, fit).value or 0.0
        error = group_jackknife(estimates_without_each(fit, self.folds, parameter.name), value)
        return value > errors_of_groups(self.n_regions) * error

    def _falls(self, parameter: Parameter, fit: Fit, squares: Floats) -> bool:
        """Return whether squared errors in regions left out, (n,) of the fit, are larger without the compliance."""
        return float(np.sum(self._squares(self._refit(_without(fit.robot, parameter))) - squares)) > 0.0

    def _refit(self, robot: CompliantRobot) -> Fit:
        return identify_parameters(self.states, robot, self.settings)

    def _squares(self, fit: Fit) -> Floats:
        """Return (n,) squared distances in regions left out, m²."""
        return squared_distances(left_out_residuals(fit, self.folds).residual, fit.data)


def expected_compliance(parameter: Parameter, fit: Fit) -> float:
    """Return the compliance, rad/(N·m) or m/N, from which follows what a payload shows of a joint.

    The joint's own where it is above zero; else that of the stiffest joint whose compliance is known to 20 %, as the
    others of the robot give at least as much. Where none is known, the typical one.
    """
    if parameter.value and _above_zero(parameter, fit):
        return parameter.value
    known = [
        other.value
        for other in fit.parameters
        if other.spec.compliance
        and other.spec.along == parameter.spec.along
        and other.spec.unit == parameter.spec.unit
        and other.value
        and other.std
        and other.value > KNOWN * other.std
    ]
    return min(known, default=parameter.spec.typical)


def payload_that_shows(fit: Fit, joint: int, compliance: float) -> float | None:
    """Return the mass in kg at the flange, in half of the poses, that shows a compliance to 20 %; None where none does.

    A kilogram turns the joint by c τ, which moves the flange by its lever about the axis.

    Parameters
    ----------
    fit : of absolute poses. joint : from 1. compliance : rad/(N·m), or m/N.
    """
    chain, angles = fit.robot.chain, fit.data.angles
    bodies = stacked_bodies(chain, angles)
    levers, torques = [], []
    for k in range(1, chain.n_joints + 1):
        lever = np.cross(bodies[k].rotation[:, 2].T, (bodies[-1].position - bodies[k].position).T)
        if k in chain.prismatic_joints:
            lever = bodies[k].rotation[:, 2].T  # it moves the flange along its axis
        levers.append(np.linalg.norm(lever, axis=1))
        torques.append(lever @ chain.gravity)
    turned = float(np.sqrt(np.mean(torques[joint - 1] ** 2)))
    largest = float(np.max(levers)) * float(np.linalg.norm(chain.gravity))
    if turned <= LEAST_LEVER * largest or compliance <= 0.0:
        return None
    shown = compliance * float(np.sqrt(np.sum((levers[joint - 1] * torques[joint - 1]) ** 2) / 2.0))
    rows = fit.data.kind == TRANSLATION
    left = fit.residual[rows][fit.data.measured_mask[rows]]
    if fit.dof <= 0:
        return None
    scatter = float(np.sqrt(np.mean(left**2) * (1.0 + len(fit.free_names) / fit.dof)))
    mass = KNOWN * scatter / shown
    if mass > chain.largest_payload:
        return None
    # less than the smallest is within what weighs anyhow
    return max(mass, LEAST_PAYLOAD * (chain.rated_payload or 0.0))


def _without(robot: CompliantRobot, parameter: Parameter) -> CompliantRobot:
    kept = (p for p in robot.placed if (p.effect.name, p.place) != (parameter.effect, parameter.place))
    return replace(robot, placed=tuple(kept))


def _with_waves(robot: CompliantRobot, joints: Sequence[int]) -> CompliantRobot:
    """Return the robot with an eccentricity of order 1 at each of these joints, in place of any of another order."""
    effect = built_in_effects()["joint-eccentricity"]
    places = {Place("joints", (joint,)) for joint in joints if joint not in robot.chain.prismatic_joints}
    own = [p for p in robot.placed if p.effect.name == effect.name and p.place in places]
    others = [p for p in own if p.values.get("order", 1.0) != 1.0]
    missing = places - {p.place for p in own} | {p.place for p in others}
    if not missing:
        return robot
    kept = tuple(p for p in robot.placed if p not in others)
    waves = (PlacedEffect(effect, p, {"order": 1.0}) for p in sorted(missing, key=lambda place: place.joints))
    return replace(robot, placed=(*kept, *waves))


def _again(parameter: Parameter, fit: Fit) -> Parameter:
    """Return a parameter in another fit."""
    return next(other for other in fit.parameters if other.name == parameter.name)


def _above_zero(parameter: Parameter, fit: Fit) -> bool:
    """Return whether a value exceeds two standard deviations, which hold what the model leaves above the noise."""
    more = 1.0 if fit.scaled or fit.reduced_chi2 is None else max(1.0, float(np.sqrt(fit.reduced_chi2)))
    return bool(parameter.value and parameter.std and parameter.value > ERRORS * more * parameter.std)


def group_jackknife(without: Floats, whole: float) -> float:
    """Return the standard error of an estimate by the jackknife over G groups; infinite where one determines it alone.

    s² = (G − 1)/G Σ (θ₍₋g₎ − θ)²: CV3 of MacKinnon, Nielsen and Webb, Journal of Econometrics 232, 2023.

    Parameters
    ----------
    without : (G,) estimates without each group, NaN where the others do not determine it. whole : of all groups.

    Examples
    --------
    >>> round(group_jackknife(np.array([1.0, 3.0]), 2.0), 12)  # of two means, the standard error of their mean
    1.0
    """
    if len(without) < 2 or not np.isfinite(without).all():
        return np.inf
    return float(np.sqrt((len(without) - 1) / len(without) * np.sum((without - whole) ** 2)))


def errors_of_groups(n_groups: int) -> float:
    """Return as many standard errors from so many groups as are exceeded by chance like `ERRORS` of a normal number.

    Examples
    --------
    >>> round(errors_of_groups(6), 2)
    2.65
    """
    from scipy.special import ndtr, stdtrit

    return float(stdtrit(n_groups - 1, ndtr(ERRORS))) if n_groups > 1 else np.inf
