"""Solving for friction: amplitudes inside, shapes outside, weight and inertia projected out, optional parts judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import InputError
from stiffcal.experiments.friction.rows import FrictionRows
from stiffcal.fault_codes import FaultCode
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.uncertainty import NORMAL_95

# Singular values below this share of the largest: combinations of inertial numbers that no motion shows.
RANK = 1e-7
ROUNDING = 1e-12
# A pooled variance of repeats with fewer degrees of freedom is worse known than that of the residuals.
LEAST_REPEATS = 4
# The weights have settled when no standard deviation changes by more than this share; they gain a digit a round.
SETTLED, MOST_ROUNDS = 1e-6, 100


@dataclass
class FrictionLaw:
    """The law of one joint while it is being fitted: which amplitudes and shapes are in, and with which values."""

    placed: PlacedEffect
    fixed: frozenset[str]
    amplitudes: list[str]
    shape: dict[str, float]
    free_nonlinear: list[str] = field(default_factory=list)
    detected: dict[str, bool] = field(default_factory=dict)
    verdict: dict[str, str] = field(default_factory=dict)

    @property
    def joint(self) -> int:
        """The joint's number, from 1."""
        return self.placed.place.joints[0]

    def held(self, symbol: str) -> bool:
        """Return whether the model file holds a parameter at its value."""
        return self.placed.parameter_name(symbol) in self.fixed

    def columns(self, velocity: Floats, shape: Mapping[str, float] | None = None) -> dict[str, Floats]:
        """Return symbol to (n,) torque per unit, at velocities (n,) and the present shape or another."""
        return self.placed.effect.torque_columns(velocity, self.shape if shape is None else shape)


def initial_friction_law(placed: PlacedEffect, fixed: frozenset[str]) -> FrictionLaw:
    """Begin without the optional parts, but for those that the model file gives."""
    optional = placed.effect.optional
    amplitudes = [spec.symbol for spec in placed.specs(ParameterRole.AMPLITUDE)]
    initial = [s for s in amplitudes if s not in optional or placed.parameter_name(s) in fixed]
    return FrictionLaw(placed, fixed, initial, dict(placed.shape()))


class PartFit:
    """The fit of rows that share unknowns, in whitened form with weight and inertia projected out."""

    def __init__(self, rows: FrictionRows, laws: list[FrictionLaw]) -> None:
        self.rows, self.laws = rows, laws
        self.rows_of_joint = {law.joint: rows.joint == law.joint for law in laws}
        self.noise = {law.joint: _repeat_noise(rows, rows.joint == law.joint) for law in laws}
        self.sigma = np.ones(len(rows))
        for law in laws:
            spread = float(rows.torque[self.rows_of_joint[law.joint]].std()) or 1.0
            self.sigma[self.rows_of_joint[law.joint]] = self.noise[law.joint] or spread
        self._whiten()

    def run(self) -> PartFit:
        """Find weights, then the optional parts, then all together."""
        self._reweigh()
        for law in self.laws:
            for symbol in law.placed.effect.optional:
                if symbol not in law.amplitudes:
                    self._try(law, symbol)
        self._refine([law for law in self.laws if law.free_nonlinear])
        for law in self.laws:
            self._judge(law)
        self._refine([law for law in self.laws if law.free_nonlinear])
        self._reweigh()
        return self

    def _whiten(self) -> None:
        nuisance = self.rows.nuisance / self.sigma[:, None]
        size = np.linalg.norm(nuisance, axis=0)
        u, s, _ = np.linalg.svd(nuisance / np.where(size > 0.0, size, 1.0), full_matrices=False)
        self.basis = u[:, s > RANK * s.max(initial=1e-300)]
        self.target = self._project_out(self.rows.torque / self.sigma)

    def _project_out(self, column: Floats) -> Floats:
        return np.asarray(column - self.basis @ (self.basis.T @ column))

    def _reweigh(self) -> None:
        """Weigh the rows by what is left of them, until the weights stand still."""
        largest = float(np.abs(self.rows.torque).max(initial=0.0))
        for _ in range(MOST_ROUNDS):
            self.solve()
            before = self.sigma.copy()
            for law in self.laws:
                of_joint = self.rows_of_joint[law.joint]
                for steady in (True, False):
                    chosen = of_joint & (self.rows.steady == steady)
                    if chosen.any() and not (steady and self.noise[law.joint]):
                        residual = self.residual[chosen] * self.sigma[chosen]
                        share = max(1.0 - self._unknowns(chosen) / chosen.sum(), 0.2)
                        self.sigma[chosen] = max(float(np.sqrt(np.mean(residual**2) / share)), 1e-12)
            self._whiten()
            # What is left of data without noise is rounding, and never the same.
            if np.all(np.abs(self.sigma - before) <= SETTLED * self.sigma + 1e-9 * largest):
                break
        else:
            joints = ", ".join(str(law.joint) for law in self.laws)
            raise InputError.at(
                FaultCode.NO_CONVERGENCE,
                "campaign.toml", "runs", f"the noise of the friction runs of joint {joints} does not settle",
                "measure each steady velocity more than once, or leave out runs whose torque follows nothing",
            )  # fmt: skip
        self.solve()

    def _unknowns(self, chosen: Booleans) -> float:
        """Unknowns that these rows pay for: those other than friction by their leverage, and the amplitudes."""
        return float((self.basis[chosen] ** 2).sum()) + 2.0

    def whitened(self, law: FrictionLaw, shape: Mapping[str, float] | None = None) -> dict[str, Floats]:
        """Return the columns of one joint, whitened and projected, for all rows."""
        of_joint = self.rows_of_joint[law.joint]
        whitened_columns = {}
        for symbol, column in law.columns(self.rows.velocity[of_joint], shape).items():
            wide = np.zeros(len(self.rows))
            wide[of_joint] = column / self.sigma[of_joint]
            whitened_columns[symbol] = self._project_out(wide)
        return whitened_columns

    def solve(self) -> Floats:
        """Find all amplitudes at the present shapes; return the whitened residual."""
        from scipy.optimize import lsq_linear

        target = self.target.copy()
        self.names: list[tuple[FrictionLaw, str]] = []
        columns: list[Floats] = []
        self.amplitude: dict[tuple[int, str], float] = {}
        for law in self.laws:
            column = self.whitened(law)
            for symbol in law.amplitudes:
                if law.held(symbol):
                    value = law.placed.values[symbol]
                    self.amplitude[law.joint, symbol] = value
                    target = target - value * column[symbol]
                else:
                    self.names.append((law, symbol))
                    columns.append(column[symbol])
        self.matrix = np.stack(columns, axis=1) if columns else np.zeros((len(self.rows), 0))
        if columns:
            lower = np.array([law.placed.effect.spec(symbol).lower for law, symbol in self.names])
            upper = np.array([law.placed.effect.spec(symbol).upper for law, symbol in self.names])
            solution = np.asarray(np.linalg.lstsq(self.matrix, target, rcond=RANK)[0])
            if (solution < lower).any() or (solution > upper).any():
                solution = lsq_linear(self.matrix, target, (lower, upper), tol=1e-12).x
            for (law, symbol), amplitude in zip(self.names, solution, strict=True):
                self.amplitude[law.joint, symbol] = float(amplitude)
            target = target - self.matrix @ solution
        self.residual = target
        return target

    def _try(self, law: FrictionLaw, symbol: str) -> None:
        """Put an optional part in where some shape of it explains more than chance would."""
        of_joint = self.rows_of_joint[law.joint]
        if not (of_joint & self.rows.steady).any():
            law.detected[symbol] = False
            law.verdict[symbol] = "not looked for, as no steady velocity was measured"
            return
        speed = np.abs(self.rows.velocity[of_joint])
        self.solve()
        basis = np.linalg.qr(self.matrix)[0]
        before = float(self.residual @ self.residual)
        best, best_shape = 0.0, dict(law.shape)
        for shape in _grid(law, symbol, speed):
            column = self.whitened(law, shape)[symbol]
            column = column - basis @ (basis.T @ column)
            size = float(column @ column)
            along = float(column @ self.residual)
            if size > 1e-9 and along > 0.0 and along**2 / size > best:
                best, best_shape = along**2 / size, shape
        law.shape = best_shape
        own_part = float(self.residual[of_joint] @ self.residual[of_joint])
        n = self._effective(of_joint)
        gain = n * np.log(own_part / max(own_part - best, 1e-12 * own_part)) if best > 0.0 else 0.0
        cost = (1.0 + len(law.placed.effect.optional[symbol])) * np.log(max(n, 2.0))
        law.detected[symbol] = bool(gain > cost and before > 0.0)
        law.verdict[symbol] = f"the information criterion falls by {gain:.3g} against a cost of {cost:.3g}"
        if law.detected[symbol]:
            law.amplitudes.append(symbol)
            law.free_nonlinear = [
                symbol_of_shape
                for symbol_of_shape in law.placed.effect.optional[symbol]
                if not law.held(symbol_of_shape)
            ]

    def _effective(self, of_joint: Booleans) -> float:
        """Return how many independent readings a joint's rows are worth.

        Each stretch costs one, its mean weight; samples of other motion overlap by half.
        """
        steady = of_joint & self.rows.steady
        n_stretches = np.unique(self.rows.piece[steady]).size
        return float(steady.sum() - n_stretches + 0.5 * (of_joint & ~self.rows.steady).sum())

    def _refine(self, laws: list[FrictionLaw]) -> None:
        """Find the shapes of all that have some, from where they are."""
        from scipy.optimize import least_squares

        where = [(law, symbol) for law in laws for symbol in law.free_nonlinear]
        if not where:
            return
        bounds = [np.log(_shape_bounds(law, symbol, np.abs(self.rows.velocity[self.rows_of_joint[law.joint]])))
                  for law, symbol in where]  # fmt: skip
        lower, upper = np.array(bounds).T

        def at(logs: Floats) -> Floats:
            for (law, symbol), value in zip(where, logs, strict=True):
                law.shape = law.shape | {symbol: float(np.exp(value))}
            return self.solve()

        start = np.array([np.log(law.shape[symbol]) for law, symbol in where])
        solution = least_squares(at, np.clip(start, lower + 1e-6, upper - 1e-6), bounds=(lower, upper), xtol=1e-8)
        if solution.status <= 0:
            names = ", ".join(law.placed.parameter_name(symbol) for law, symbol in where)
            raise InputError.at(
                FaultCode.NO_CONVERGENCE, "campaign.toml", "runs", f"the fit of {names} does not settle",
                "measure more velocities, or fix them in model.toml",
            )  # fmt: skip
        at(solution.x)

    def _judge(self, law: FrictionLaw) -> None:
        """Take an optional part out again where its interval holds zero; hold shapes that nothing determines."""
        for symbol, shapes in law.placed.effect.optional.items():
            if not law.detected.get(symbol):
                continue
            free, covariance = self.covariance(law)
            for shape in reversed(shapes):
                if shape in free:
                    std = float(np.sqrt(covariance[free.index(shape), free.index(shape)]))
                    spec = law.placed.effect.spec(shape)
                    if std > 0.5 * law.shape[shape] and shape != shapes[0]:
                        law.free_nonlinear.remove(shape)
                        law.shape = law.shape | {shape: spec.typical}
                        self._refine([law])
                        free, covariance = self.covariance(law)
            value = self.amplitude[law.joint, symbol]
            std = float(np.sqrt(covariance[free.index(symbol), free.index(symbol)]))
            if not value - NORMAL_95 * std > 0.0:
                law.detected[symbol] = False
                law.verdict[symbol] += f", but its 95 % interval ({value:.3g} ± {NORMAL_95 * std:.2g} N·m) holds zero"
                law.amplitudes.remove(symbol)
                law.free_nonlinear = [shape_symbol for shape_symbol in law.free_nonlinear if shape_symbol not in shapes]
                self.solve()

    def covariance(self, law: FrictionLaw) -> tuple[list[str], Floats]:
        """Return the free symbols of a joint and their covariance: amplitudes, then shapes."""
        names, matrix = self._jacobian()
        inverse = np.linalg.pinv(matrix.T @ matrix, rcond=1e-13)
        whole = inverse
        moving = ~self.rows.steady
        if moving.any():  # neighbouring samples err alike: by whole pieces of motion (White 1980, in clusters)
            clusters = np.unique(np.stack([self.rows.joint, self.rows.piece], axis=1), axis=0, return_inverse=True)[1]
            scores = np.zeros((int(clusters.max()) + 1, matrix.shape[1]))
            np.add.at(scores, clusters.ravel(), matrix * self.residual[:, None])
            robust = inverse @ (scores.T @ scores) @ inverse * len(scores) / max(len(scores) - 1, 1)
            larger = np.sqrt(np.maximum(np.diagonal(robust) / np.diagonal(inverse), 1.0))
            whole = inverse * larger[:, None] * larger[None, :]
        columns_of_law = [k for k, (owner, _) in enumerate(names) if owner is law]
        return [names[k][1] for k in columns_of_law], np.asarray(
            whole[np.ix_(columns_of_law, columns_of_law)], dtype=np.float64
        )

    def friction(self) -> Floats:
        """Return (k,) N·m, the friction of every row as fitted."""
        torque = np.zeros(len(self.rows))
        for law in self.laws:
            of_joint = self.rows_of_joint[law.joint]
            columns = law.columns(self.rows.velocity[of_joint])
            torque[of_joint] = sum(self.amplitude[law.joint, symbol] * columns[symbol] for symbol in law.amplitudes)
        return torque

    def unknowns(self) -> Floats:
        """Return (m,) weight, inertia and zeros."""
        nuisance = self.rows.nuisance / self.sigma[:, None]
        size = np.linalg.norm(nuisance, axis=0)
        scale = np.where(size > 0.0, size, 1.0)
        remaining = (self.rows.torque - self.friction()) / self.sigma
        return np.asarray(np.linalg.lstsq(nuisance / scale, remaining, rcond=RANK)[0] / scale)

    def unknowns_std(self) -> Floats:
        """Return (m,) standard uncertainties of these, neighbouring samples taken by whole pieces of motion."""
        nuisance = self.rows.nuisance / self.sigma[:, None]
        size = np.linalg.norm(nuisance, axis=0)
        scale = np.where(size > 0.0, size, 1.0)
        inverse = np.linalg.pinv(np.concatenate([nuisance / scale, self.matrix], axis=1), rcond=RANK)[: scale.size]
        keys = np.stack([self.rows.joint, self.rows.piece], axis=1)
        clusters = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
        scores = np.zeros((int(clusters.max()) + 1, scale.size))
        np.add.at(scores, clusters, inverse.T * self.residual[:, None])
        return np.asarray(np.sqrt((scores**2).sum(axis=0) * len(scores) / max(len(scores) - 1, 1)) / scale)

    def condition(self) -> float:
        """Return the condition number of the whitened friction columns, each of unit length."""
        size = np.linalg.norm(self.matrix, axis=0)
        if size.size == 0 or not size.all():
            return 1.0
        return float(np.linalg.cond(self.matrix / size))

    def _jacobian(self) -> tuple[list[tuple[FrictionLaw, str]], Floats]:
        names, columns = list(self.names), [self.matrix]
        for law in self.laws:
            for symbol in law.free_nonlinear:
                small = 1e-4 * law.shape[symbol]
                ends = [
                    self.whitened(law, law.shape | {symbol: law.shape[symbol] + direction * small})
                    for direction in (1, -1)
                ]
                slope = sum(
                    self.amplitude[law.joint, amplitude_symbol]
                    * (ends[0][amplitude_symbol] - ends[1][amplitude_symbol])
                    / (2.0 * small)
                    for amplitude_symbol in law.amplitudes
                )
                names.append((law, symbol))
                columns.append(np.asarray(slope)[:, None])
        return names, np.concatenate(columns, axis=1)


def _grid(law: FrictionLaw, symbol: str, speed: Floats) -> list[dict[str, float]]:
    """Return shapes to try: fading within the slower part of the speeds, bluntly or sharply."""
    values = []
    for shape in law.placed.effect.optional[symbol]:
        low, high = _shape_bounds(law, shape, speed)
        spec = law.placed.effect.spec(shape)
        if law.held(shape):
            values.append([law.placed.values[shape]])
        elif spec.unit == "rad/s":
            values.append(list(np.geomspace(low, high, 13)))
        else:
            values.append([spec.typical])
    names = law.placed.effect.optional[symbol]
    return [law.shape | dict(zip(names, combination, strict=True)) for combination in product(*values)]


def _shape_bounds(law: FrictionLaw, symbol: str, speed: Floats) -> tuple[float, float]:
    """A speed of fading outside the slower half of what was measured would be dry or viscous friction."""
    spec = law.placed.effect.spec(symbol)
    if spec.unit != "rad/s":
        return spec.lower, spec.upper
    low = max(spec.lower, 0.5 * float(speed.min()))
    return low, max(min(spec.upper, 0.5 * float(speed.max())), 1.01 * low)


def _repeat_noise(rows: FrictionRows, of_joint: Booleans) -> float | None:
    """Return the pooled standard deviation of a joint's repeats, N·m; None where there are too few."""
    chosen = of_joint & rows.steady
    squares, dof = 0.0, 0
    for number in np.unique(rows.repeat[chosen]):
        same = rows.torque[chosen & (rows.repeat == number)]
        squares += float(((same - same.mean()) ** 2).sum())
        dof += same.size - 1
    # Repeats that agree to rounding are copies: they carry no information on the noise.
    least = len(rows.torque) * (ROUNDING * float(np.abs(rows.torque[chosen]).max(initial=0.0))) ** 2
    return float(np.sqrt(squares / dof)) if dof >= LEAST_REPEATS and squares > least else None
