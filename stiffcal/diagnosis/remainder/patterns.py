"""Which joint's compliance varies with what, where nothing in the catalogue accounts for the remainder.

Each run gives an apparent compliance of every joint: what the residuals of that run, read along the joint's own
deflection, amount to. A joint whose compliance follows a joint's angle or torque, the size of the load or the time
shows so over the runs. Every such dependence is tried as an addition to the model, everything else refitted, in poses
left out, as the catalogue's effects are; `stiffcal effects new` writes the effect that tests the best of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, cast

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.pattern_results import (
    CandidateParameter,
    CompliancePattern,
    FollowedBy,
    PatternAlternative,
    PatternPoint,
)
from stiffcal.diagnosis.refits.heldout_error import left_out_rms
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.scans.lack_of_fit import alike, fitted_values, judge
from stiffcal.diagnosis.scans.load_scan import LoadScan, scan_candidates
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.diagnosis.thresholds import LEAST_EXPLAINED, MOST_ALTERNATIVES
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.varying import varies
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Law,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
    tool_node,
)
from stiffcal.model.laws.drives import drive_terms, drive_torque

# Waves per turn of the joint that is followed: from what is nearly straight over half a turn to what an eccentric with
# four rollers makes.
ORDERS = np.arange(0.5, 4.01, 0.25)
# Points of the drawn curve.
CURVE_POINTS = 61
_AMPLITUDE = "found by the diagnosis"


@dataclass(frozen=True)
class Followed:
    """What a compliance may follow."""

    by: FollowedBy
    """Its kind."""
    joint: int = 0
    """Whose angle, torque or motion, from 1; 0 for what belongs to no joint."""
    scale: float = 1.0
    """N·m, N or s, of the largest torque or load or the latest time: laws of these are in shares of it."""

    def of(self, chain: Chain, loads: NodeLoads) -> Floats:
        """Return (n,) its values: rad, or shares of ``scale``."""
        if self.by is FollowedBy.JOINT_ANGLE:
            return np.asarray(loads.angles[self.joint - 1])
        if self.by is FollowedBy.JOINT_TORQUE:
            return np.asarray(np.abs(drive_torque(chain, loads.wrench, self.joint)) / self.scale)
        if self.by is FollowedBy.LOAD:
            return np.asarray(np.linalg.norm(loads.wrench[tool_node(chain), :3], axis=0) / self.scale)
        if self.by is FollowedBy.LAST_MOTION:
            direction = 0.0 if loads.order is None else loads.order.direction(self.joint)
            return np.asarray(direction * np.sign(drive_torque(chain, loads.wrench, self.joint)))
        if loads.order is None:
            # Without a load no time is known; what the weight does then is constant within a run.
            return np.zeros(loads.angles.shape[1])
        return np.asarray(loads.order.time / self.scale)


class _FollowingCompliance(Law):
    """A joint's compliance follows an angle, δ_Rz = (a cos mq + b sin mq) τ, load or time, δ_Rz = (a s + b s²) τ.

    Or the direction s of a last motion, with the torque or against it, δ_Rz = a s τ: friction that grows with the load.
    """

    place_kind = "joints"
    followed: ClassVar[Followed]

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return the two terms of the law."""
        joint, value = place.joints[0], self.followed.of(chain, loads)
        torque = drive_torque(chain, loads.wrench, joint)
        if self.followed.by is FollowedBy.LAST_MOTION:
            # its square is a compliance that follows nothing
            return drive_terms(chain, joint, "a", value * torque)
        first, second = basis(self.followed.by, value, shape)
        return (*drive_terms(chain, joint, "a", first * torque), *drive_terms(chain, joint, "b", second * torque))

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Return the orders to try."""
        return {"order": ORDERS} if self.followed.by is FollowedBy.JOINT_ANGLE else {}


class _ConstantCompliance(Law):
    """A joint's compliance by itself, to read its apparent value in each run."""

    name = "constant compliance"
    place_kind = "joints"
    summary = "a joint gives in proportion to its torque"
    parameters = (ParameterSpec("c", "rad/(N·m)", "compliance", -np.inf, np.inf, 1e-6, _AMPLITUDE),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c τ."""
        return drive_terms(chain, place.joints[0], "c", drive_torque(chain, loads.wrench, place.joints[0]))


def basis(by: FollowedBy, value: Floats, shape: Values) -> tuple[Floats, Floats]:
    """Return the two (n,) functions of what is followed that the law is made of."""
    if by is FollowedBy.JOINT_ANGLE:
        return np.asarray(np.cos(shape["order"] * value)), np.asarray(np.sin(shape["order"] * value))
    return value, np.zeros_like(value) if by is FollowedBy.LAST_MOTION else np.asarray(value**2)


def find_pattern(fit: Fit, states: LoadStates) -> CompliancePattern | None:
    """Return the dependence of a joint's compliance that the remainder of a fit supports best; None where none is.

    None also where the best explains less than four fifths: as for effects, half of a structure is easily mimicked.

    Parameters
    ----------
    fit : of the model whose remainder nothing in the catalogue accounts for.
    states : the campaign's load states.
    """
    candidates = [
        Candidate(_law(followed), Place("joints", (joint,)), 3)
        for followed in _followed(fit, states)
        for joint in range(1, fit.robot.chain.n_joints + 1)
        if joint not in fit.robot.chain.prismatic_joints
    ]
    scan = scan_candidates(fit, candidates, geometry=GeometryNuisance.of(states, fit))
    supported = [
        trial for trial in scan.trials if judge(scan, trial).supported and _share(scan, trial) >= LEAST_EXPLAINED
    ]
    if not supported:
        return None
    best = supported[0]
    others = [trial for trial in supported[1:] if alike(scan, trial, best)][:MOST_ALTERNATIVES]
    followed = _followed_by(best)
    joint = best.candidate.place.joints[0]
    points = _points(scan, states, joint, followed)
    share = _share(scan, best)
    return CompliancePattern(
        joint=joint,
        follows=followed.by,
        of_joint=followed.joint or None,
        share=share,
        p_value=judge(scan, best).p_value,
        heldout_rms_before=left_out_rms(scan, None),
        heldout_rms_after=left_out_rms(scan, best),
        scale=followed.scale,
        parameters=[
            CandidateParameter(symbol=symbol, value=value, unit=best.candidate.effect.spec(symbol).unit)
            for symbol, value in fitted_values(best).items()
        ],
        alternatives=[
            PatternAlternative(
                joint=trial.candidate.place.joints[0],
                follows=_followed_by(trial).by,
                of_joint=_followed_by(trial).joint or None,
                share=_share(scan, trial),
            )
            for trial in others
        ],
        points=points,
        curve=_curve(best, followed, points),
    )


def _followed(fit: Fit, states: LoadStates) -> list[Followed]:
    """Return what varies over these states: joint angles and torques, the load's size, the time."""
    chain, state = fit.robot.chain, Linearised.about(fit.robot, fit.data)
    joints = [joint for joint in range(1, chain.n_joints + 1) if joint not in chain.prismatic_joints]
    angles = [Followed(FollowedBy.JOINT_ANGLE, joint) for joint in joints]
    unscaled = [*(Followed(FollowedBy.JOINT_TORQUE, joint) for joint in joints), Followed(FollowedBy.LOAD)]
    if np.isfinite(fit.data.order.time).all():
        unscaled.append(Followed(FollowedBy.TIME))
    if fit.data.order.approach.any():
        angles += [Followed(FollowedBy.LAST_MOTION, joint) for joint in joints]
    sizes = [float(np.abs(followed.of(chain, state.loads)).max(initial=0.0)) for followed in unscaled]
    scaled = [replace(followed, scale=size) for followed, size in zip(unscaled, sizes, strict=True) if size > 0.0]
    return [followed for followed in (*angles, *scaled) if varies(followed.of(chain, state.loads))]


def _law(followed: Followed) -> _FollowingCompliance:
    """Return the law of a joint's compliance that follows something."""
    unit = "rad/(N·m)"
    parameters = [
        ParameterSpec(symbol, unit, f"amplitude of part {number}", -np.inf, np.inf, 2e-7, _AMPLITUDE)
        for number, symbol in enumerate("a" if followed.by is FollowedBy.LAST_MOTION else "ab", start=1)
    ]
    if followed.by is FollowedBy.JOINT_ANGLE:
        meaning = "waves per turn of the joint that is followed"
        parameters.append(
            ParameterSpec("order", "1", meaning, ORDERS[0], ORDERS[-1], 1.0, _AMPLITUDE, ParameterRole.NONLINEAR)
        )
    attributes = {
        "name": f"compliance over {followed.by.value} {followed.joint or ''}".strip(),
        "summary": "a joint's compliance that follows something else",
        "parameters": tuple(parameters),
        "followed": followed,
    }
    law: _FollowingCompliance = type("FollowingCompliance", (_FollowingCompliance,), attributes)()
    return law


def _followed_by(trial: Trial) -> Followed:
    return cast("_FollowingCompliance", trial.candidate.effect).followed


def _share(scan: LoadScan, trial: Trial) -> float:
    """Return the share of the avoidable error in poses left out that goes; of all of it where no noise is known."""
    before, after = float(scan.base.heldout.sum()), float(trial.score.heldout.sum())
    floor = float(scan.dof) if scan.fit.noise is not None else 0.0
    return float(np.clip((before - after) / max(before - floor, 1e-12 * before), 0.0, 1.0))


def _points(scan: LoadScan, states: LoadStates, joint: int, followed: Followed) -> list[PatternPoint]:
    """Return the joint's apparent change of compliance in each run, where the run determines one."""
    data, state = scan.fit.data, scan.source.state()
    regressor = state.regressor(_ConstantCompliance(), Place("joints", (joint,)), {})
    rows = scan.space.rows(np.concatenate([regressor.columns, scan.residual[None]]))
    column, residual = (row.reshape(-1, data.n_states) for row in rows)
    value = followed.of(scan.fit.robot.chain, state.loads)
    points = []
    for members in members_of(data.run):
        information = float(np.sum(column[:, members] ** 2))
        if information <= 0.0:
            continue
        points.append(
            PatternPoint(
                run=states.runs[data.run[members[0]]].name,
                at=float(np.mean(value[members])),
                compliance=float(np.sum(column[:, members] * residual[:, members])) / information,
                std=1.0 / float(np.sqrt(information)),
            )
        )
    largest = min((point.std for point in points), default=0.0) * 30.0
    return [point for point in points if point.std <= largest]


def _curve(trial: Trial, followed: Followed, points: Sequence[PatternPoint]) -> list[list[float]]:
    """Return the fitted law over what it follows, shifted to the points: the model holds the compliance's mean."""
    if not points:
        return []
    values = fitted_values(trial)
    at = np.array([point.at for point in points])
    weight = np.array([1.0 / point.std**2 for point in points])

    def law(over: Floats) -> Floats:
        first, second = basis(followed.by, over, values)
        return np.asarray(values["a"] * first + values.get("b", 0.0) * second)

    shift = float(np.average(np.array([point.compliance for point in points]) - law(at), weights=weight))
    over = np.linspace(float(at.min()), float(at.max()), CURVE_POINTS)
    return [[float(x), float(y)] for x, y in zip(over, law(over) + shift, strict=True)]
