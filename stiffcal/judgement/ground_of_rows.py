"""A model of torque over motion with values, about which members are compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.scans.drift import Drift, drift_of
from stiffcal.diagnosis.thresholds import MANY_ROW_SHAPES
from stiffcal.estimation.bins import Bins
from stiffcal.identification.fitting.regressors import Regressor, RegressorMaker
from stiffcal.judgement.covariance_kind import CovarianceKind
from stiffcal.judgement.discrepancy import Discrepancy, OffRun
from stiffcal.judgement.ground import CheckKind, Ground
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import OF_LOADS, OF_TIME, WAVES
from stiffcal.judgement.shared import Shared
from stiffcal.kinds.row_search import RowCourse, RowFit
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect, Place


@dataclass(frozen=True)
class RowData:
    """k rows of one component."""

    run: Integers
    """(k,) number of the pass, or of the piece of other motion."""

    @property
    def index(self) -> Integers:
        """(k,) number of each row."""
        return np.arange(len(self.run))

    @property
    def measured_mask(self) -> Booleans:
        """(1, k) True: of each row the torque was read."""
        return np.ones((1, len(self.run)), dtype=np.bool_)

    @property
    def kind(self) -> Integers:
        """(1,) all of one kind."""
        return np.zeros(1, dtype=np.int64)

    @property
    def absolute(self) -> Booleans:
        """(k,) False."""
        return np.zeros(len(self.run), dtype=np.bool_)


@dataclass(frozen=True)
class WeightedRows:
    """Weights of k rows; constants are columns that every hypothesis has."""

    data: RowData
    """The rows."""
    sigma: Floats
    """(k,) standard uncertainty of each."""

    @property
    def scale(self) -> Floats:
        """(1, k) one over it."""
        return 1.0 / self.sigma[None]

    @property
    def free(self) -> Floats:
        """(1, k) ones: no constant is taken out."""
        return np.ones((1, len(self.sigma)))

    @property
    def independent(self) -> bool:
        """True: there is one component."""
        return True

    def rows(self, stack: Floats) -> Floats:
        """Return (q, k) whitened rows of (q, 1, k)."""
        return np.asarray(stack[:, 0] / self.sigma)

    def unwhitened(self, rows: Floats) -> Floats:
        """Return (1, k) readings of whitened rows (k,)."""
        return np.asarray(rows * self.sigma)[None]


@dataclass(frozen=True)
class MeansMaker:
    """Makes the regressors of effects, as means over bins of rows."""

    maker: RegressorMaker
    """Makes those of the rows."""
    bins: Bins
    """Of them."""

    def shapes(self, effect: Effect, place: Place) -> list[dict[str, float]]:
        """Return the combinations of shape parameters to try."""
        return self.maker.shapes(effect, place)

    def regressor(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor:
        """Return an effect's regressor."""
        made = self.maker.regressor(effect, place, shape)
        return replace(made, columns=self.bins.means(made.columns), fixed=self.bins.means(made.fixed))


@dataclass(frozen=True)
class GroundOfRows(Ground):
    """A model of torque over motion, fitted to rows of one problem."""

    space: WeightedRows
    """Their weights."""
    course: RowCourse
    """In which order they were read."""

    # a shape costs an inner product of some hundred rows: all orders of a ripple are tried
    most_shapes: ClassVar[int] = MANY_ROW_SHAPES
    checked: ClassVar[Mapping[CheckKind, Integers]] = {CheckKind.TORQUE: np.zeros(1, dtype=np.int64)}

    @classmethod
    def of(cls, fit: RowFit, common: CompliantRobot, course: RowCourse, bins: Bins, sigma: Floats) -> Self:
        """Return what members are compared about.

        Parameters
        ----------
        fit : of a model. common : effects that every hypothesis has. course : of the bins.
        bins : of the rows, which are judged as means. sigma : (b,) standard uncertainty of each mean.
        """
        own = {(placed.effect.name, placed.place) for placed in common.placed}
        present = tuple(one for one in fit.robot.placed if (one.effect.name, one.place) not in own)
        of_members = {one.parameter_name(spec.symbol) for one in present for spec in one.effect.parameters}
        columns_of = zip(fit.rows.unknowns.names, fit.rows.derivative[:, 0], strict=True)
        shared = [bins.means(column) for name, column in columns_of if name not in of_members]
        constants = np.unique(fit.constant[fit.constant >= 0])
        shared += [bins.means((fit.constant == number).astype(np.float64)) for number in constants]
        space = WeightedRows(RowData(course.group), sigma)
        columns = space.rows(np.array(shared).reshape(-1, 1, len(sigma)))
        of_poses, of_time = _of_passes(space, course), _of_time(space, course)
        kinds: list[tuple[CovarianceKind, float]] = [(of_poses, OF_LOADS), (of_time, OF_TIME)]
        prior = np.zeros((0, len(columns) + 1))
        residual = bins.means(_without_constants(fit))[None]
        scale = NoiseScale(float(len(sigma) - len(columns)), 0.0)
        return cls(
            MeansMaker(fit.maker, bins), space, Shared(columns, prior, kinds), residual, present, {}, of_poses,
            of_time, None, None, scale, course,
        )  # fmt: skip

    @property
    def drift(self) -> Drift:
        """How far friction, or the sensor's zero, wanders on from pass to pass."""
        order = np.lexsort((self.course.time, self.course.joint))
        joint, white, mask = self.course.joint[order], self.white[order], self.space.data.measured_mask
        length = float(np.median(np.unique(joint, return_counts=True)[1]))
        ways = (self.course.direction[order], np.ones(len(joint)))
        found = [drift_of(joint, mask, (way * white)[None], self.noise.dof, length) for way in ways]
        return min(found, key=lambda one: one.p_value)

    @property
    def stated(self) -> Integers:
        """The torque."""
        return np.zeros(1, dtype=np.int64)

    def runs_off(self) -> Iterator[OffRun]:
        """Give the constant by which each pass alone may be off."""
        for run, (place, moved) in self.of_loads.moves.items():
            yield OffRun(run, place, moved[:, :1] / np.sqrt(np.mean(moved[:, 0] ** 2)))


def _without_constants(fit: RowFit) -> Floats:
    """Return (k,) what a fit leaves, its free constants taken out."""
    left, weight = fit.rows.residual[0].copy(), 1.0 / fit.sigma**2
    for number in np.unique(fit.constant[fit.constant >= 0]):
        own = fit.constant == number
        left[own] -= np.sum(weight[own] * left[own]) / np.sum(weight[own])
    return np.asarray(left)


def _of_passes(space: WeightedRows, course: RowCourse) -> Discrepancy:
    """Return each pass's own friction."""
    return Discrepancy.of_drivers(space, [np.ones(len(course.group))], course.group)


def _of_time(space: WeightedRows, course: RowCourse) -> Discrepancy:
    """Return each joint's friction, and the zero of its sensor, as they walk at random."""
    part = np.zeros(len(course.time))
    for joint in np.unique(course.joint):
        own = course.joint == joint
        part[own] = (course.time[own] - course.time[own].min()) / max(float(np.ptp(course.time[own])), 1e-300)
    waves = [np.cos(np.pi * k * part) / k for k in range(1, WAVES + 1)]
    size = float(np.sqrt(sum(1.0 / k**2 for k in range(1, WAVES + 1))))
    drivers = [way * wave / size for way in (course.direction, np.ones(len(part))) for wave in waves]
    return Discrepancy.of_drivers(space, drivers, course.joint)
