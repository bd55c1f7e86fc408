"""Friction runs as rows for the diagnosis: joints that share unknowns are one problem."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.fitting.regressors import Regressor
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.kinds.friction.answers.documents import identified_friction
from stiffcal.kinds.friction.fitting.drive_space import DriveSpace, first_sigma
from stiffcal.kinds.friction.fitting.joint_fits import joint_fit
from stiffcal.kinds.friction.fitting.part_fit import PartFit
from stiffcal.kinds.friction.fitting.row_columns import RowColumns
from stiffcal.kinds.friction.fitting.starting import grid_shapes
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, UnknownKind, together
from stiffcal.kinds.row_search import RowCourse, RowCovariate, RowFit, RowNoise, RowProblem, UsualMotion
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, Place
from stiffcal.model.motion import Motion, as_motion, is_constant_torque
from stiffcal.wording import significant


@dataclass(frozen=True)
class _Maker:
    """Makes the regressors of effects that show in motion."""

    made: RowColumns

    def shapes(self, effect: Effect, place: Place) -> list[dict[str, float]]:
        """Return the combinations of the effect's grid."""
        return grid_shapes(self.made, effect, place)

    def regressor(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor:
        """Return an effect's torque per unit of its amplitudes, (q, 1, k)."""
        return _regressor(effect, place, shape, self.made.of(effect, place, shape), len(self.made.rows))


def _regressor(
    effect: Effect, place: Place, shape: Mapping[str, float], columns: Mapping[str, Floats], k: int
) -> Regressor:
    stack = np.stack([column[None] for column in columns.values()]) if columns else np.zeros((0, 1, k))
    return Regressor(effect, place, dict(shape), tuple(columns), stack, np.zeros((1, k)))


class FrictionProblem(RowProblem):
    """Friction rows of joints that share unknowns.

    Parameters
    ----------
    rows : of these joints. index : (k,) their numbers among all rows.
    placed : effects of the model file that show in their motion.
    chain : the robot. fixed : full names of parameters that the model file fixes.
    """

    measure, unit = "torque", "N·m"

    def __init__(
        self, rows: FrictionRows, index: Integers, placed: tuple[PlacedEffect, ...], chain: Chain,
        fixed: frozenset[str],
    ) -> None:  # fmt: skip
        self.index = index
        self._rows, self._chain, self._fixed = rows, chain, fixed
        self._made = RowColumns(rows, chain)
        self._robot = CompliantRobot(chain, placed)
        self.joints = tuple(sorted(set(rows.joint.tolist())))
        steady = bool(rows.steady.all())
        self.subject = SearchSubject(
            "motion", "Torque over motion", "at held-out speeds" if steady else "in held-out seconds of motion"
        )
        self.folds_in_words = "speeds" if steady else "seconds of motion"

    @property
    def robot(self) -> CompliantRobot:
        """The present model of these joints."""
        return self._robot

    def fit(self, robot: CompliantRobot) -> RowFit:
        """Fit a model to the rows."""
        fit = PartFit.of(self._rows, robot.placed, self._chain, self._fixed)
        known = bool(fit.source.noise_known.all())
        identified = [one for joint in fit.joints for one in identified_friction(joint_fit(fit, joint))]
        return RowFit(
            robot=robot.with_values(fit.values),
            rows=fit.linearised(),
            noise=RowNoise(float(fit.rows.noise_dof.min()), "neighbours") if known else None,
            sigma=fit.sigma,
            constant=_constants(fit.rows),
            fold=fit.rows.piece,
            run=np.unique(fit.rows.run, return_inverse=True)[1].astype(np.int64),
            maker=_Maker(fit.source.made),
            parameters=fit.parameters,
            identified=tuple(identified),
        )

    def places(self, effect: Effect) -> list[Place]:
        """Return the joints of an effect that shows in motion."""
        if not isinstance(effect, Motion):
            return []
        return [place for place in effect.places(self._chain) if place.joints and place.joints[0] in self.joints]

    def lacking(self, effect: Effect, place: Place) -> str | None:
        """Return the data missing to determine an effect of a joint, or None."""
        joint, law = place.joints[0], as_motion(effect)
        of_joint = self._rows.joint == joint
        constants = (UnknownKind.STRETCH, UnknownKind.TORQUE_ZERO)
        absorbed = any(
            unknown.kind in constants and self._rows.nuisance[of_joint, k].any()
            for k, unknown in enumerate(self._rows.unknown)
        )
        if absorbed and is_constant_torque(law, place, self._chain):
            return "an axis without torque of weight: with weight, free constants absorb a constant torque"
        return law.lacking_motion(self._chain, self._rows.motion_of(joint, with_travel=True))

    def covariates(self) -> list[RowCovariate]:
        """Return temperature, time, time in the run, position, speed and load, as far as they were logged and vary."""
        rows, motion = self._rows, self._rows.motion
        time = rows.means(motion.time)
        in_run = time.copy()
        for name in np.unique(rows.run):
            in_run[rows.run == name] -= float(time[rows.run == name].min())
        several = np.unique(rows.run).size > 1
        found = [
            RowCovariate(
                "temperature", rows.means(motion.temperature), "the residual depends on the logged temperature"
            ),
            RowCovariate("time", time, "the residual drifts with time since the first sample"),
            RowCovariate(
                "time in the run",
                in_run if several else np.zeros(len(rows)),
                "in each run the residual drifts in the same way",
            ),
            RowCovariate("position", rows.means(motion.angle), "the residual depends on the joint angle"),
            RowCovariate("speed", np.log(np.abs(rows.velocity) + 1e-12), "the residual depends on the speed"),
            RowCovariate("load", np.abs(rows.means(motion.load)), "the residual depends on the torque of the weight"),
        ]
        return [
            covariate for covariate in found if np.isfinite(covariate.value).all() and np.ptp(covariate.value) > 0.0
        ]

    def course(self) -> RowCourse:
        """Return in which order the rows were read, and which err together."""
        rows = self._rows
        steady = np.column_stack([np.where(rows.steady, rows.source, -1), rows.piece, rows.joint])
        group = np.unique(steady, axis=0, return_inverse=True)[1].ravel().astype(np.int64)
        time = rows.means(rows.motion.time)
        return RowCourse(rows.joint, time, np.asarray(np.sign(rows.velocity)), group)

    def group_in_words(self, group: int) -> str:
        """Return a pass, or a second of other motion, in words."""
        rows, own = self._rows, np.flatnonzero(self.course().group == group)
        time, joint, run = rows.means(rows.motion.time)[own], int(rows.joint[own[0]]), rows.run[own[0]]
        when = f'{significant(time.min())} s after the first reading, in run "{run}"'
        if not rows.steady[own[0]]:
            return f"the motion of joint {joint} from {when}"
        return f"the pass of joint {joint} at {significant(float(np.mean(rows.velocity[own])))} rad/s, {when}"

    def usual(self, joint: int) -> UsualMotion:
        """Return how a joint moves and resists."""
        own = self._rows.select(self._rows.joint == joint)
        space = DriveSpace.of(own, first_sigma(own))
        left = space.rows(own.torque[None, None])[0] * space.sigma
        return UsualMotion(float(np.sqrt(np.mean(left**2))), float(np.sqrt(np.mean(own.velocity**2))))

    def with_time_for_temperature(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor | None:
        """Return an effect's regressor with the time in place of the temperature; None where it follows none."""
        motion = self._rows.motion_of(place.joints[0])
        if not np.isfinite(motion.temperature).all() or np.ptp(motion.time) <= 0.0:
            return None
        law = as_motion(effect)
        warm = law.motion_columns(place, self._chain, motion, shape)
        cold = law.motion_columns(place, self._chain, replace(motion, temperature=np.zeros(len(motion))), shape)
        if all(np.array_equal(warm[symbol], cold[symbol]) for symbol in warm):
            return None
        clock = motion.time / np.ptp(motion.time) * np.ptp(motion.temperature)
        timed = law.motion_columns(place, self._chain, replace(motion, temperature=clock), shape)
        return _regressor(effect, place, shape, self._made.averaged(place, timed), len(self._rows))


def friction_problems(
    rows: FrictionRows, index: Integers, placed: tuple[PlacedEffect, ...], chain: Chain, fixed: frozenset[str]
) -> tuple[RowProblem, ...]:
    """Return the problems of all joints; of joints that share no unknown each is one by itself.

    Parameters
    ----------
    rows : k rows that are searched. index : (k,) their numbers among all rows of the campaign.
    placed : effects of the model that show in motion. chain : the robot. fixed : as for `FrictionProblem`.
    """
    problems = []
    for group in together(rows):
        own = rows.select(group)
        joints = set(own.joint.tolist())
        effects = tuple(effect for effect in placed if effect.place.joints[0] in joints)
        problems.append(FrictionProblem(own, index[group], effects, chain, fixed))
    return tuple(problems)


def _constants(rows: FrictionRows) -> Integers:
    """Return (k,) which free constant each row carries, −1 for none."""
    constant = np.full(len(rows), -1, dtype=np.int64)
    for number, unknown in enumerate(rows.unknown):
        if unknown.kind is UnknownKind.STRETCH:
            constant[rows.nuisance[:, number] != 0.0] = number
    return constant
