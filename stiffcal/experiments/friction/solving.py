"""Solving for what drives' motion makes: amplitudes inside, shapes outside, weight and inertia projected out."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise, product

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import InputError
from stiffcal.experiments.friction.drive_law import DriveLaw
from stiffcal.experiments.friction.rows import FrictionRows, UnknownKind
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterSpec

# Singular values below this share of the largest: combinations of inertial numbers that no motion shows.
RANK = 1e-7
# A column of which less than this share of its length is left next to weight and zeros is rounding.
ABSORBED = 1e-9
# The weights have settled when no standard deviation changes by more than this share; they gain a digit a round.
SETTLED, MOST_ROUNDS = 1e-6, 100
# A shape whose standard uncertainty is more than this share of it is not determined.
UNDETERMINED = 0.5


class PartFit:
    """The fit of rows that share unknowns, in whitened form with weight and inertia projected out."""

    def __init__(self, rows: FrictionRows, laws: list[DriveLaw], chain: Chain) -> None:
        for law in laws:
            if law.placed.effect.constant_torque:
                # The constants at each speed would absorb it.
                rows = rows.without(UnknownKind.STRETCH, law.joint)
        self.rows, self.laws, self.chain = rows, laws, chain
        self.joints = sorted(set(rows.joint.tolist()))
        self.rows_of_joint = {joint: rows.joint == joint for joint in self.joints}
        self.motion = {joint: rows.motion_of(joint) for joint in self.joints}
        self._row_of_sample = {joint: rows.row[rows.joint[rows.row] == joint] for joint in self.joints}
        self._count = np.maximum(np.bincount(rows.row, minlength=len(rows)), 1)
        self.noise_known = np.isfinite(rows.sigma)
        spread = np.ones(len(rows))
        for joint in self.joints:
            spread[self.rows_of_joint[joint]] = float(rows.torque[self.rows_of_joint[joint]].std()) or 1.0
        self.sigma = np.where(self.noise_known, rows.sigma, spread)
        self._whiten()

    def run(self, start: Mapping[str, float] | None = None) -> PartFit:
        """Find weights, then shapes.

        Parameters
        ----------
        start : shapes by full name to begin with, of a fit of nearly the same rows; grids are tried where None.
        """
        self._reweigh()
        for law in self.laws:
            if start is not None:
                own = {symbol: law.placed.parameter_name(symbol) for symbol in law.shape}
                law.shape |= {symbol: start[name] for symbol, name in own.items() if name in start}
                self._set_bounds(law)
            elif law.free_nonlinear or law.chosen:
                self._try_shapes(law)
        self._refine()
        if start is None:
            self._hold_undetermined()
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
        """Weigh rows whose noise is not known by what is left of them, until the weights stand still."""
        self.solve()
        if self.noise_known.all():
            return
        largest = float(np.abs(self.rows.torque).max(initial=0.0))
        for _ in range(MOST_ROUNDS):
            before = self.sigma.copy()
            for joint in self.joints:
                of_joint = self.rows_of_joint[joint] & ~self.noise_known
                for steady in (True, False):
                    chosen = of_joint & (self.rows.steady == steady)
                    if chosen.any():
                        residual = self.residual[chosen] * self.sigma[chosen]
                        share = max(1.0 - self._unknowns(chosen) / chosen.sum(), 0.2)
                        self.sigma[chosen] = max(float(np.sqrt(np.mean(residual**2) / share)), 1e-12)
            self._whiten()
            self.solve()
            # What is left of data without noise is rounding, and never the same.
            if np.all(np.abs(self.sigma - before) <= SETTLED * self.sigma + 1e-9 * largest):
                return
        joints = ", ".join(str(joint) for joint in self.joints)
        raise InputError.at(
            FaultCode.NO_CONVERGENCE,
            "campaign.toml", "runs", f"the noise estimate of the friction runs of joint {joints} does not converge",
            "measure each constant velocity more than once, or exclude runs whose torque is unrelated to the motion",
        )  # fmt: skip

    def _unknowns(self, chosen: Booleans) -> float:
        """Unknowns that these rows pay for: those other than friction by their leverage, and the amplitudes."""
        return float((self.basis[chosen] ** 2).sum()) + 2.0

    def columns(self, placed: PlacedEffect, shape: Mapping[str, float]) -> dict[str, Floats]:
        """Return symbol to (k,) torque per unit, averaged over the samples of each row; 0 for other joints' rows."""
        joint = placed.place.joints[0]
        per_sample = placed.effect.motion_columns(placed.place, self.chain, self.motion[joint], shape)
        row, k = self._row_of_sample[joint], len(self.rows)
        return {
            symbol: np.asarray(np.bincount(row, weights=column, minlength=k) / self._count)
            for symbol, column in per_sample.items()
        }

    def whitened(self, law: DriveLaw, shape: Mapping[str, float] | None = None) -> dict[str, Floats]:
        """Return the columns of one law, whitened and projected, for all rows."""
        columns = self.columns(law.placed, law.shape if shape is None else shape)
        projected = {}
        for symbol, column in columns.items():
            left = self._project_out(column / self.sigma)
            absorbed = np.linalg.norm(left) <= ABSORBED * np.linalg.norm(column / self.sigma)
            projected[symbol] = np.zeros_like(left) if absorbed else left
        return projected

    def solve(self) -> Floats:
        """Find all amplitudes at the present shapes; return the whitened residual."""
        from scipy.optimize import lsq_linear

        target = self.target.copy()
        self.names: list[tuple[DriveLaw, str]] = []
        columns: list[Floats] = []
        sizes: list[float] = []
        self.amplitude: dict[str, float] = {}
        for law in self.laws:
            column = self.whitened(law)
            torque = self.columns(law.placed, law.shape)
            for symbol in law.amplitudes:
                if law.held(symbol):
                    value = law.placed.values[symbol]
                    self.amplitude[law.placed.parameter_name(symbol)] = value
                    target = target - value * column[symbol]
                else:
                    self.names.append((law, symbol))
                    columns.append(column[symbol])
                    sizes.append(float(np.linalg.norm(torque[symbol] / self.sigma)))
        self.matrix = np.stack(columns, axis=1) if columns else np.zeros((len(self.rows), 0))
        self.column_size = np.array(sizes)
        if columns:
            lower = np.array([law.placed.effect.spec(symbol).lower for law, symbol in self.names])
            upper = np.array([law.placed.effect.spec(symbol).upper for law, symbol in self.names])
            size = np.linalg.norm(self.matrix, axis=0)
            nonzero = size > 0.0  # what weight and zeros absorb is 0: nothing in these rows depends on it
            scaled, bounds = (
                self.matrix[:, nonzero] / size[nonzero],
                (lower[nonzero] * size[nonzero], upper[nonzero] * size[nonzero]),
            )
            unit = np.asarray(np.linalg.lstsq(scaled, target, rcond=RANK)[0])
            if (unit < bounds[0]).any() or (unit > bounds[1]).any():
                unit = lsq_linear(scaled, target, bounds, tol=1e-12).x
            solution = np.zeros(len(columns))
            solution[nonzero] = unit / size[nonzero]
            for (law, symbol), amplitude in zip(self.names, solution, strict=True):
                self.amplitude[law.placed.parameter_name(symbol)] = float(amplitude)
            target = target - self.matrix @ solution
        self.residual = target
        return target

    def shapes(self, law: DriveLaw) -> list[dict[str, float]]:
        """Return the shapes to try: those of the effect's grid that are possible, what the model file holds kept."""
        effect = law.placed.effect
        grid = effect.motion_grid(law.placed.place, self.chain, self.rows.motion_of(law.joint, with_travel=True))
        values = [[law.shape[symbol]] if law.held(symbol) else grid[symbol].tolist() for symbol in grid]
        shapes = [law.shape | dict(zip(grid, combination, strict=True)) for combination in product(*values)]
        return [shape for shape in shapes if effect.impossible(shape) is None]

    def _try_shapes(self, law: DriveLaw) -> None:
        """Take the shape of the effect's grid that leaves least, everything else refitted."""
        shapes = self.shapes(law)
        self._set_bounds(law)
        if not shapes:
            return
        others = [column for (owner, _), column in zip(self.names, self.matrix.T, strict=True) if owner is not law]
        basis = np.linalg.qr(np.stack(others, axis=1))[0] if others else np.zeros((len(self.rows), 0))
        held = {symbol: law.placed.values[symbol] for symbol in law.amplitudes if law.held(symbol)}
        own = [symbol for symbol in law.amplitudes if symbol not in held]
        present = self.whitened(law)
        target = self.residual + sum(
            self.amplitude[law.placed.parameter_name(symbol)] * present[symbol] for symbol in law.amplitudes
        )
        best, least = shapes[0], np.inf
        for shape in shapes:
            columns = self.whitened(law, shape)
            rest = target - sum(value * columns[symbol] for symbol, value in held.items())
            rest = rest - basis @ (basis.T @ rest)
            matrix = np.stack([columns[symbol] - basis @ (basis.T @ columns[symbol]) for symbol in own], axis=1)
            if not own:
                left = float(rest @ rest)
            else:
                solution = np.linalg.lstsq(matrix, rest, rcond=1e-9)[0]
                lower = np.array([law.placed.effect.spec(symbol).lower for symbol in own])
                left = float(np.sum((rest - matrix @ np.maximum(solution, lower)) ** 2))
            if left < least * (1.0 - 1e-12):
                best, least = shape, left
        law.shape = dict(best)
        self._set_bounds(law)
        self.solve()

    def _set_bounds(self, law: DriveLaw) -> None:
        """Let each shape go as far as its effect's grid reaches, and no further than what is possible."""
        effect = law.placed.effect
        grid = effect.motion_grid(law.placed.place, self.chain, self.rows.motion_of(law.joint))
        for symbol in law.free_nonlinear:
            spec, value = effect.spec(symbol), law.shape[symbol]
            values = np.sort(grid.get(symbol, np.array([value])))
            low, high = _reach(spec, values, value)
            for first, second in pairwise(values.tolist()):
                if effect.impossible(law.shape | {symbol: 0.5 * (first + second)}) is not None:
                    low, high = (max(low, second), high) if second <= value else (low, min(high, first))
            law.bounds[symbol] = (low, high)

    def _refine(self) -> None:
        """Find the shapes of all that have some, from where they are."""
        from scipy.optimize import least_squares

        where = [(law, symbol) for law in self.laws for symbol in law.free_nonlinear]
        if not where:
            self.solve()
            return
        lower, upper = np.log(np.array([law.bounds[symbol] for law, symbol in where])).T
        upper = np.maximum(upper, lower + 1e-9)

        def at(logs: Floats) -> Floats:
            for (law, symbol), value in zip(where, logs, strict=True):
                law.shape = law.shape | {symbol: float(np.exp(value))}
            return self.solve()

        start = np.array([np.log(law.shape[symbol]) for law, symbol in where])
        inside = 1e-3 * (upper - lower)
        solution = least_squares(at, np.clip(start, lower + inside, upper - inside), bounds=(lower, upper), xtol=1e-8)
        if solution.status <= 0:
            names = ", ".join(law.placed.parameter_name(symbol) for law, symbol in where)
            raise InputError.at(
                FaultCode.NO_CONVERGENCE, "campaign.toml", "runs", f"the fit of {names} does not converge",
                "measure more velocities, or fix them in model.toml",
            )  # fmt: skip
        at(solution.x)

    def _hold_undetermined(self) -> None:
        """Hold shapes that nothing determines at their usual values, but for the first of each law."""
        changed = False
        for joint in self.joints:
            free, covariance = self.covariance(joint)
            for law in (law for law in self.laws if law.joint == joint):
                for symbol in law.free_nonlinear[:0:-1]:
                    k = free.index(law.placed.parameter_name(symbol))
                    if np.sqrt(covariance[k, k]) > UNDETERMINED * law.shape[symbol]:
                        law.free_nonlinear.remove(symbol)
                        law.shape = law.shape | {symbol: law.placed.effect.spec(symbol).typical}
                        changed = True
                        break
        if changed:
            self._refine()
            self._hold_undetermined()

    def covariance(self, joint: int) -> tuple[list[str], Floats]:
        """Return the full names of a joint's free parameters and their covariance: amplitudes, then shapes."""
        names, matrix = self.jacobian()
        inverse = _inverse_normal(matrix)
        whole = inverse
        moving = ~self.rows.steady
        if moving.any():  # neighbouring samples err alike: by whole pieces of motion (White 1980, in clusters)
            clusters = np.unique(np.stack([self.rows.joint, self.rows.piece], axis=1), axis=0, return_inverse=True)[1]
            scores = np.zeros((int(clusters.max()) + 1, matrix.shape[1]))
            np.add.at(scores, clusters.ravel(), matrix * self.residual[:, None])
            robust = inverse @ (scores.T @ scores) @ inverse * len(scores) / max(len(scores) - 1, 1)
            own = np.diagonal(inverse)  # 0 where weight and zeros absorb a column
            larger = np.sqrt(np.maximum(np.diagonal(robust) / np.where(own > 0.0, own, np.inf), 1.0))
            whole = inverse * larger[:, None] * larger[None, :]
        chosen = [k for k, (owner, _) in enumerate(names) if owner.joint == joint]
        full = [names[k][0].placed.parameter_name(names[k][1]) for k in chosen]
        return full, np.asarray(whole[np.ix_(chosen, chosen)], dtype=np.float64)

    def friction(self) -> Floats:
        """Return (k,) N·m, what the laws make of every row as fitted."""
        torque = np.zeros(len(self.rows))
        for law in self.laws:
            for symbol, column in self.columns(law.placed, law.shape).items():
                torque += self.amplitude[law.placed.parameter_name(symbol)] * column
        return torque

    def other_than_velocity(self) -> Floats:
        """Return (k,) N·m of the laws that follow more than the velocity."""
        torque = np.zeros(len(self.rows))
        for law in self.laws:
            if not law.placed.effect.torque_columns(np.ones(1), law.shape):
                torque += self._torque_of(law, law.shape)
        return torque

    def values(self) -> dict[str, float]:
        """Return full name to value of every parameter."""
        shapes = {law.placed.parameter_name(symbol): v for law in self.laws for symbol, v in law.shape.items()}
        return {**self.amplitude, **shapes}

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

    def jacobian(self) -> tuple[list[tuple[DriveLaw, str]], Floats]:
        """Return the free parameters and their (k, p) whitened, projected columns: amplitudes, then shapes."""
        names, columns = list(self.names), [self.matrix]
        for law, symbol, slope in self.shape_slopes():
            names.append((law, symbol))
            columns.append(self._project_out(slope / self.sigma)[:, None])
        return names, np.concatenate(columns, axis=1)

    def shape_slopes(self) -> list[tuple[DriveLaw, str, Floats]]:
        """Return each free shape parameter with the (k,) change of torque per unit of it, N·m."""
        slopes = []
        for law in self.laws:
            for symbol in law.free_nonlinear:
                small = 1e-4 * law.shape[symbol]
                ends = [self._torque_of(law, law.shape | {symbol: law.shape[symbol] + way * small}) for way in (1, -1)]
                slopes.append((law, symbol, (ends[0] - ends[1]) / (2.0 * small)))
        return slopes

    def _torque_of(self, law: DriveLaw, shape: Mapping[str, float]) -> Floats:
        total = np.zeros(len(self.rows))
        for symbol, column in self.columns(law.placed, shape).items():
            total += self.amplitude[law.placed.parameter_name(symbol)] * column
        return total


def _reach(spec: ParameterSpec, grid: Floats, value: float) -> tuple[float, float]:
    """Return how far a shape may go: to its bounds, or as far as a grid of speeds and angles reaches in these data."""
    if spec.unit in ("rad/s", "rad") and grid.size > 1:
        low, high = max(spec.lower, float(grid[0])), min(spec.upper, float(grid[-1]))
        return min(low, value), max(high, value)
    return min(spec.lower, value), max(spec.upper, value)


def _inverse_normal(matrix: Floats) -> Floats:
    """Return (p, p) the inverse of the columns' inner products, of columns of unit length within."""
    size = np.linalg.norm(matrix, axis=0)
    scale = np.where(size > 0.0, size, 1.0)
    return np.asarray(np.linalg.pinv((matrix / scale).T @ (matrix / scale), rcond=1e-13) / np.outer(scale, scale))
