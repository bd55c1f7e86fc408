"""A fit of rows that share unknowns: laws' parameters with their covariance, and weight, inertia and zeros."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError, no_progress
from stiffcal.estimation.parameters import Parameter, reported_parameters
from stiffcal.estimation.rows import Rows, joined
from stiffcal.estimation.solve import Settled, settle
from stiffcal.estimation.unknowns import Unknowns, amplitudes
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.friction.fitting.drive_space import RANK, DriveSpace
from stiffcal.kinds.friction.fitting.source import MotionSource
from stiffcal.kinds.friction.fitting.starting import shapes_to_find, with_best_shapes, within_reach
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.model.motion import as_motion
from stiffcal.uncertainty import NORMAL_95

# A shape whose standard uncertainty is more than this share of it is not determined.
UNDETERMINED = 0.5


@dataclass(frozen=True)
class PartFit:
    """A fit of k rows that share unknowns."""

    source: MotionSource
    """The rows and p free parameters."""
    settled: Settled[DriveSpace]
    """Where the fit ended."""
    usual: frozenset[str] = frozenset()
    """Full names of shapes that these rows do not determine, held at their usual values."""

    @classmethod
    def of(
        cls, rows: FrictionRows, placed: tuple[PlacedEffect, ...], chain: Chain, fixed: frozenset[str] = frozenset()
    ) -> PartFit:
        """Fit effects to rows; arguments as of `MotionSource.of`.

        Raises
        ------
        InputError : the fit does not settle.
        """
        source = MotionSource.of(rows, placed, chain, fixed)
        shapes = frozenset(np.array(source.unknowns.names)[source.unknowns.nonlinear].tolist())
        begun = _settled(source.holding(shapes))
        if shapes_to_find(source):
            source = within_reach(replace(source, robot=with_best_shapes(source, begun.weights)))
            begun = _settled(source.holding(shapes))
        return _with_shapes(source, begun, shapes)

    @property
    def rows(self) -> FrictionRows:
        """The k rows."""
        return self.source.rows

    @property
    def space(self) -> DriveSpace:
        """Noise and other unknowns of the rows."""
        return self.settled.weights

    @property
    def sigma(self) -> Floats:
        """(k,) N·m, standard uncertainty that each row was weighted with."""
        return self.settled.weights.sigma

    @property
    def joints(self) -> list[int]:
        """The joints of the rows, from 1."""
        return sorted(set(self.rows.joint.tolist()))

    @cached_property
    def robot(self) -> CompliantRobot:
        """The effects with what was found of them."""
        return self.source.robot_at(self.settled.values)

    @cached_property
    def solved(self) -> MotionSource:
        """The source of the q parameters that were solved for."""
        held = self.settled.checked.left_at_neutral
        names = [name for name, is_held in zip(self.source.unknowns.names, held.tolist(), strict=True) if is_held]
        return replace(self.source, robot=self.robot).holding(names)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters, in the order of the model and of each effect."""
        names, std = self.solved.unknowns.names, np.sqrt(np.diagonal(self.covariance)).tolist()
        spread = {name: one for name, one in zip(names, std, strict=True) if name not in self.unidentified}
        held = self.source.fixed | self.usual
        free = self.source.unknowns
        reach = dict(zip(free.names, zip(free.lower.tolist(), free.upper.tolist(), strict=True), strict=True))
        return tuple(reported_parameters(self.robot, spread, NORMAL_95, held, reach))

    @property
    def unidentified(self) -> frozenset[str]:
        """Full names of parameters that the rows do not determine."""
        known = self.settled.checked.identifiable.tolist()
        return frozenset(name for name, is_known in zip(self.source.unknowns.names, known, strict=True) if not is_known)

    @cached_property
    def own_rows(self) -> Rows:
        """The rows about the estimates of the q parameters, other unknowns taken out."""
        return self.solved.about(amplitudes(self.robot, self.solved.columns), self.space)

    def linearised(self) -> Rows:
        """Return the rows about the estimates, unknowns that several speeds share after the q parameters.

        Constants of one speed are taken out.
        """
        own, columns = self.own_rows, self.space.shared_columns
        free = Unknowns.plain([f"shared {number + 1}" for number in range(len(columns))])
        # of shared unknowns what is left is the least: they are counted from where they explain most
        shared = own.residual[0] / self.sigma @ self.space.shared
        return replace(
            own,
            unknowns=joined(own.unknowns, free),
            values=np.append(own.values, shared),
            derivative=np.concatenate([own.derivative, columns[:, None]]),
            predicted=own.predicted + (shared @ columns)[None],
            space=self.space.with_shared_free(),
            prior=np.zeros((0, len(own.values) + len(shared) + 1)),
        )

    @property
    def residual(self) -> Floats:
        """(k,) whitened, other unknowns taken out."""
        return np.asarray(self.own_rows.white[-1])

    @property
    def friction(self) -> Floats:
        """(k,) N·m, what the laws make of every row."""
        return np.asarray(self.own_rows.predicted[0])

    @property
    def other_than_velocity(self) -> Floats:
        """(k,) N·m of the laws that follow more than the velocity."""
        torque = np.zeros(len(self.rows))
        for placed in self.robot.placed:
            if not as_motion(placed.effect).torque_columns(np.ones(1), placed.shape()):
                torque += self.solved.torque_of(placed)
        return torque

    @property
    def values(self) -> dict[str, float]:
        """Full name to the value that every parameter counts with."""
        return {
            placed.parameter_name(spec.symbol): placed.values.get(spec.symbol, usual)
            for placed in self.robot.placed
            for spec in placed.effect.parameters
            for usual in [placed.shape().get(spec.symbol, spec.neutral)]
        }

    @property
    def dof(self) -> int:
        """Rows less all that was fitted to them."""
        chosen = [
            spec
            for placed in self.robot.placed
            for spec in placed.specs(ParameterRole.NONLINEAR)
            if spec.discrete and placed.parameter_name(spec.symbol) not in self.source.fixed
        ]
        return self.own_rows.dof - len(self.solved.columns) - len(chosen)

    @cached_property
    def covariance(self) -> Floats:
        """(q, q) of the parameters that were solved for, in the order of ``solved``."""
        columns = self.own_rows.white[:-1]
        inverse = self.own_rows.reduced().covariance(np.ones(len(columns), dtype=np.bool_))
        if self.rows.steady.all() or not len(columns):
            return inverse
        # neighbouring samples err alike: by whole pieces of motion (White 1980, in clusters)
        robust = inverse @ clustered(self.rows, columns * self.residual) @ inverse
        larger = np.sqrt(np.maximum(np.diagonal(robust) / np.diagonal(inverse), 1.0))
        return np.asarray(inverse * larger[:, None] * larger)

    @cached_property
    def unknowns(self) -> Floats:
        """(m,) weight, inertia and zeros; of collinear ones the combination of least norm."""
        unit, scale = self._unit_nuisance
        remaining = self.own_rows.residual[0] / self.sigma
        return np.asarray(np.linalg.lstsq(unit, remaining, rcond=RANK)[0] / scale)

    @property
    def unknowns_std(self) -> Floats:
        """(m,) standard uncertainties of these, neighbouring samples taken by whole pieces of motion."""
        unit, scale = self._unit_nuisance
        columns = np.concatenate([unit, self.own_rows.white[:-1].T], axis=1)
        inverse = np.linalg.pinv(columns, rcond=RANK)[: scale.size]
        return np.asarray(np.sqrt(np.diagonal(clustered(self.rows, inverse * self.residual))) / scale)

    @property
    def _unit_nuisance(self) -> tuple[Floats, Floats]:
        """(k, m) whitened columns of the other unknowns, of unit length, and (m,) their lengths."""
        nuisance = self.rows.nuisance / self.sigma[:, None]
        size = np.linalg.norm(nuisance, axis=0)
        scale = np.where(size > 0.0, size, 1.0)
        return nuisance / scale, scale


def clustered(rows: FrictionRows, scores: Floats) -> Floats:
    """Return (q, q) the covariance of sums of scores (q, k) whose pieces of motion are independent."""
    number = np.unique(np.stack([rows.joint, rows.piece], axis=1), axis=0, return_inverse=True)[1].ravel()
    count = int(number.max()) + 1
    sums = np.zeros((count, len(scores)))
    np.add.at(sums, number, scores.T)
    return np.asarray(sums.T @ sums * count / max(count - 1, 1))


def _with_shapes(source: MotionSource, begun: Settled[DriveSpace], shapes: Collection[str]) -> PartFit:
    """Return the fit with shapes free; those that nothing determines are held, but for the first of each law."""
    plain = source.holding(shapes)
    source = replace(source, robot=plain.robot_at(begun.values))
    fit, usual = PartFit(source, begun), frozenset[str]()
    if not source.unknowns.nonlinear.any():
        return fit
    while True:
        fit = PartFit(source, _settled(source), usual)
        more = _undetermined_shapes(fit)
        if not more:
            return fit
        usual |= more.keys()
        source = replace(source, robot=fit.robot.with_values(more)).holding(more)


def _undetermined_shapes(fit: PartFit) -> dict[str, float]:
    """Return full name to usual value of shapes that are not determined, one of each law at a time."""
    names, std = fit.solved.unknowns.names, np.sqrt(np.diagonal(fit.covariance))
    spread = dict(zip(names, std.tolist(), strict=True))
    found = {}
    for number, placed in enumerate(fit.robot.placed):
        free = [column.symbol for column in fit.source.columns if column.placed == number]
        shapes = [symbol for symbol, value in placed.shape().items() if symbol in free]
        for symbol in shapes[:0:-1]:
            name = placed.parameter_name(symbol)
            if spread.get(name, np.inf) > UNDETERMINED * placed.shape()[symbol]:
                found[name] = placed.effect.spec(symbol).typical
                break
    return found


def _settled(source: MotionSource) -> Settled[DriveSpace]:
    settled = settle(source, amplitudes(source.robot, source.columns), None, no_progress)
    if settled.last_step is not None:
        names = ", ".join(source.unknowns.names)
        raise InputError.at(
            FaultCode.NO_CONVERGENCE, "campaign.toml", "runs", f"the fit of {names} does not converge",
            "measure more velocities, each more than once, or exclude runs whose torque is unrelated to the motion",
        )  # fmt: skip
    return settled
