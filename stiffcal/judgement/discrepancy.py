"""The discrepancy that every hypothesis carries: each pose may answer its loads in a way of its own, or wander in time.

Per run a random linear response of every component to the load, or a random walk of every component, of a size τ common
to all runs. With V = I + τ² D Dᵀ, block by block of runs, and D = U √λ Wᵀ, every inner product under V⁻¹ is one of
plain rows less one of the rows' parts along U, each weighed by τ²λ / (1 + τ²λ): any number of sizes costs one
projection. What lasts in every run as well (`lasting_errors`) is part of V: with 1 + Z Zᵀ = S⁻² it is
S⁻¹ (1 + τ² S D Dᵀ S) S⁻¹, and with S D = U √λ Wᵀ rows lose their parts along S U beyond what they lose along Z.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.scans.drift import walking_together
from stiffcal.diagnosis.scans.geometry_nuisance import LEAST_SHOWN
from stiffcal.estimation.decomposition import thin_svd
from stiffcal.identification.noise.projection import Projection
from stiffcal.judgement.covariance_kind import weighed_products
from stiffcal.judgement.like_states import sweeps_of
from stiffcal.judgement.numbers import (
    DISCREPANCIES,
    LEAST_DIRECTION,
    LOUDER,
    MOST_OF_RUN,
    NUMBERS_AT_ONCE,
    RUN_SIZES,
    SHOWS_ITS_NOISE,
    WAVES,
)
from stiffcal.judgement.space import Space


@dataclass(frozen=True)
class AlikeRuns:
    """Runs, or single components of them, of as many rows and directions."""

    number: Integers
    """(g,) places of the runs among all."""
    place: Integers
    """(g, r) positions of their rows."""
    basis: Floats
    """(g, r, d) directions, the one of most variance first: orthonormal, or so next to what lasts as well."""
    at: Integers
    """(g, d) places of these among all directions."""


@dataclass(frozen=True)
class Discrepancy:
    """Directions in whitened rows into which the poses' own responses move the readings."""

    runs: tuple[int, ...]
    """Numbers of the runs, or groups of states."""
    n_rows: int
    """Whitened rows of all."""
    alike: Sequence[AlikeRuns]
    """All runs."""
    variance: Floats
    """(d in all,) along each direction, for a discrepancy of one noise."""

    @classmethod
    def of_loads(cls, space: Projection, lasting: Discrepancy | None = None) -> Discrepancy:
        """Return each run's own response to its loads, and of absolute places each row's own offset.

        Parameters
        ----------
        space : weights and runs of load states. lasting : as of `of_drivers`.
        """
        data = space.data
        drivers = _unit_loads(data.wrench)
        if data.absolute.any():
            drivers = [*drivers, data.absolute.astype(np.float64)]
        return cls.of_drivers(space, drivers, data.run, lasting)

    @classmethod
    def of_time(cls, space: Projection, lasting: Discrepancy | None = None) -> Discrepancy:
        """Return each run's own random walk, as waves over it whose variance falls with the square of their number.

        (Karhunen and Loève: the waves of a random walk.) All absolute places walk together, in their order.
        """
        data = space.data
        group = walking_together(data)
        part = np.zeros(data.n_states)
        for number in np.unique(group):
            own = np.flatnonzero(group == number)
            part[own] = np.arange(len(own)) / max(len(own) - 1, 1)
        waves = [np.cos(np.pi * k * part) / k for k in range(1, WAVES + 1)]
        size = float(np.sqrt(sum(1.0 / k**2 for k in range(1, WAVES + 1)) / 2.0))
        return cls.of_drivers(space, [wave / size for wave in waves], group, lasting)

    @classmethod
    def of_like_states(cls, space: Projection) -> Discrepancy | None:
        """Return by what like states of sweeps err alike, each place by itself; None where no clamped motor swept.

        A sweep is cut into states where it bends, and each is one point of a stretch of a curve: what that makes
        returns with the cycle (`stiffcal.kinds.clamped.states.states`).
        """
        data = space.data
        m, n = data.measured.shape
        alike, variances, runs = list[AlikeRuns](), list[Floats](), list[int]()
        for sweep in sweeps_of(data):
            columns = np.zeros((len(sweep.places), m, n))
            columns[:, sweep.row, sweep.states] = sweep.places / space.whitening.scale[sweep.row, sweep.states]
            own = space.rows(columns).reshape(columns.shape)[:, sweep.row, sweep.states]
            basis, values, _ = thin_svd(own.T)
            kept = values**2 > LEAST_DIRECTION * max(float(values.max(initial=0.0)) ** 2, 1e-300)
            at = sum(len(one) for one in variances) + np.arange(np.count_nonzero(kept))
            number = np.full(1, len(runs), dtype=np.int64)
            alike.append(AlikeRuns(number, (sweep.row * n + sweep.states)[None], basis[None, :, kept], at[None]))
            variances.append(values[kept] ** 2)
            runs.append(sweep.run)
        return cls(tuple(runs), m * n, alike, np.concatenate(variances)) if runs else None

    @classmethod
    def of_lasting(cls, space: Space, makes: Floats, group: Integers) -> Discrepancy:
        """Return what (k, m, n) of one standard deviation each, all in each run by itself, makes as far as it shows."""
        m, n = space.free.shape
        return cls._by_group(space.rows(makes), np.arange(m)[None], n, group, lambda values: values > LEAST_SHOWN)

    @classmethod
    def of_drivers(
        cls, space: Space, drivers: Sequence[Floats], group: Integers, lasting: Discrepancy | None = None
    ) -> Discrepancy:
        """Return the responses of each component in each run, or group of states (n,), to drivers (n,) of one noise.

        Parameters
        ----------
        lasting : a discrepancy of one noise that is there as well: what is taken out of rows is beyond that, and the
            directions are orthonormal next to it.
        """
        m, n = space.free.shape
        size = np.array([1.0 / np.median(row[row > 0.0]) if (row > 0.0).any() else 0.0 for row in space.scale])
        # of components that err by themselves each has directions of its own, from one stack for all of them
        parts = np.arange(m).reshape((m, 1) if space.independent and lasting is None else (1, m))
        stack = np.zeros((len(drivers) * parts.shape[1], m, n))
        for k, driver in enumerate(drivers):
            for c, own in enumerate(parts.T):
                stack[k * parts.shape[1] + c, own] = driver * size[own, None]
        rows = space.rows(stack)
        del stack

        def shown(values: Floats) -> Booleans:
            most = np.maximum(values.max(axis=1, initial=0.0) ** 2, 1e-300)
            return np.asarray(values**2 > LEAST_DIRECTION * most[:, None])

        if lasting is None:
            return cls._by_group(rows, parts, n, group, shown)
        root = 1.0 - 1.0 / np.sqrt(1.0 + lasting.variance)
        found = cls._by_group(lasting.taken_out(rows, root), parts, n, group, shown)
        alike = []
        at_once = max(NUMBERS_AT_ONCE // (m * n), 1)
        for one in found.alike:
            basis = np.empty_like(one.basis)
            for first in range(0, basis.shape[2], at_once):
                those = slice(first, first + at_once)
                part = np.moveaxis(one.basis[:, :, those], 2, 0)
                whole = np.zeros((len(part), m * n))
                whole[:, one.place] = part
                basis[:, :, those] = np.moveaxis(lasting.taken_out(whole, root)[:, one.place], 0, 2)
            alike.append(replace(one, basis=basis))
        return replace(found, alike=alike)

    @classmethod
    def _by_group(
        cls, rows: Floats, parts: Integers, n: int, group: Integers, shown: Callable[[Floats], Booleans]
    ) -> Discrepancy:
        """Return the directions of whitened rows (k, m · n) in each group of states, for parts of the components.

        Parameters
        ----------
        parts : (p, c) components that have directions together. n : states. group : (n,) of them.
        shown : of singular values (g, d) which count.
        """
        numbers, counts = np.unique(group, return_counts=True)
        states = np.split(np.argsort(group, kind="stable"), np.cumsum(counts)[:-1])
        alike, at = list[AlikeRuns](), 0
        variances = list[Floats]()
        for count in np.unique(counts):
            long = np.flatnonzero(counts == count)
            place = parts[:, :, None] * n + np.array([states[k] for k in long])[:, None, None]
            long, place = np.repeat(long, len(parts)), place.reshape(len(long) * len(parts), -1)
            bases, values, _ = thin_svd(np.moveaxis(rows[:, place], 0, 2))
            for d in np.unique(kept := shown(values).sum(axis=1)).tolist():
                own = kept == d
                numbered = at + np.arange(d * np.count_nonzero(own)).reshape(np.count_nonzero(own), d)
                alike.append(AlikeRuns(long[own], place[own], bases[own][:, :, :d], numbered))
                variances.append(values[own][:, :d].ravel() ** 2)
                at += numbered.size
        return cls(tuple(numbers.tolist()), rows.shape[1], alike, np.concatenate([np.zeros(0), *variances]))

    @property
    def of_run(self) -> list[tuple[Integers, Floats, Floats]]:
        """Per run positions (r,) of its rows, orthonormal directions (r, d) and the variances (d,) along these."""
        parts: list[list[tuple[Integers, Floats, Floats]]] = [[] for _ in self.runs]
        for one in self.alike:
            for k, place, basis, at in zip(one.number, one.place, one.basis, one.at, strict=True):
                parts[k].append((place, basis, self.variance[at]))
        return [own[0] if len(own) == 1 else _joined(own) for own in parts]

    @property
    def moves(self) -> dict[int, tuple[Integers, Floats]]:
        """Per run the positions (r,) of its rows, and (r, d) how a discrepancy of one noise moves them."""
        return {
            run: (place, basis * np.sqrt(variance))
            for run, (place, basis, variance) in zip(self.runs, self.of_run, strict=True)
        }

    @property
    def sizes(self) -> Floats:
        """Grid of its size, in noises."""
        return DISCREPANCIES

    def along(self, rows: Floats) -> Floats:
        """Return (k, d) the parts of whitened rows (k, r) along the directions."""
        found = np.empty((len(rows), len(self.variance)))
        for one in self.alike:
            found[:, one.at] = np.swapaxes(np.swapaxes(rows[:, one.place], 0, 1) @ one.basis, 0, 1)
        return found

    def products(self, rows: Floats, along: Floats, others: Floats, along_others: Floats, plain: Floats) -> Floats:
        """Return (s, k, l) by how much inner products are less at each size; as of `CovarianceKind.products`."""
        return weighed_products(self._weights, along, along_others)

    @cached_property
    def _weights(self) -> Floats:
        """(s, d) of every size."""
        return np.array([self.weights(size) for size in self.sizes])

    def taken_out(self, rows: Floats, weights: Floats, found: Floats | None = None) -> Floats:
        """Return rows (k, r) less their parts along the directions times weights (d,).

        Parameters
        ----------
        found : (k, r) in place of the rows themselves, from which the parts are taken, in place.
        """
        found = rows.copy() if found is None else found
        for one in self.alike:
            along = (np.swapaxes(rows[:, one.place], 0, 1) @ one.basis) * weights[one.at][:, None]
            found[:, one.place] -= np.swapaxes(along @ np.swapaxes(one.basis, 1, 2), 0, 1)
        return found

    def variance_of_noise(self, weights: Floats) -> Floats:
        """Return (r,) the variance of each row's noise: what poses answer is none."""
        return np.ones(self.n_rows)

    def leverage(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row that lies along the directions, times weights (d,)."""
        found = np.zeros(self.n_rows)
        for one in self.alike:
            found[one.place] = np.einsum("grd,gd->gr", one.basis**2, weights[one.at])
        return found

    def weights(self, size: float) -> Floats:
        """Return (d,) τ²λ / (1 + τ²λ) for a discrepancy of so many noises."""
        grown = size**2 * self.variance
        return np.asarray(grown / (1.0 + grown))

    def log_determinant(self, size: float) -> float:
        """Return log |V|."""
        return float(np.sum(np.log1p(size**2 * self.variance)))


@dataclass(frozen=True)
class LouderRun:
    """A run of which every reading scatters more than those of the others."""

    run: int
    """Its number."""
    n_rows: int
    """Whitened rows of all."""
    place: Integers
    """(d,) positions of its rows."""
    free: float
    """Of its readings, what its constants have taken out."""
    basis: Floats
    """(d, q) orthonormal directions of what lasts in the run …"""
    known: Floats
    """(q,) and its variance along these, in that of the noise."""

    @classmethod
    def of(cls, space: Space, white: Floats, lasting: Discrepancy | None = None) -> LouderRun | None:
        """Return the run of which most is left, where there are several.

        Parameters
        ----------
        white : (r,) whitened residual. lasting : what is in each run as well, whatever its noise.
        """
        data, (m, n) = space.data, space.free.shape
        free = space.free.sum(axis=0)
        numbers, position = np.unique(np.where(data.absolute, -1, data.run), return_inverse=True)
        per_run = np.bincount(position, weights=free)
        square = np.bincount(position, weights=np.sum(white.reshape(m, n) ** 2, axis=0))
        able = (numbers >= 0) & (per_run >= SHOWS_ITS_NOISE)
        if np.count_nonzero(able) < 2:
            return None
        k = int(np.argmax(np.where(able, square / np.maximum(per_run, 1e-300), 0.0)))
        states = np.flatnonzero(position == k)
        place = (np.arange(m)[:, None] * n + states).ravel()
        basis, known = np.zeros((len(place), 0)), np.zeros(0)
        if lasting is not None:
            _, basis, known = lasting.of_run[lasting.runs.index(int(numbers[k]))]
        return cls(int(numbers[k]), m * n, place, float(per_run[k]), basis, known)

    @property
    def sizes(self) -> Floats:
        """Grid of what is added to its noise, in noises."""
        return LOUDER

    def along(self, rows: Floats) -> Floats:
        """Return (k, d + q) whitened rows (k, r) in the run, and their parts along what lasts in it."""
        own = rows[:, self.place]
        return np.concatenate([own, own @ self.basis], axis=1)

    def products(self, rows: Floats, along: Floats, others: Floats, along_others: Floats, plain: Floats) -> Floats:
        """Return (s, k, l) by how much inner products are less at each size; as of `CovarianceKind.products`."""
        return weighed_products(self._weights, along, along_others)

    @cached_property
    def _weights(self) -> Floats:
        """(s, d + q) of every size."""
        return np.array([self.weights(size) for size in self.sizes])

    def taken_out(self, rows: Floats, weights: Floats, found: Floats | None = None) -> Floats:
        """Return rows (k, r) less those of the run times weights (d + q,); parameters as of `Discrepancy.taken_out`."""
        found, d = rows.copy() if found is None else found, len(self.place)
        own = rows[:, self.place]
        found[:, self.place] -= own * weights[:d] + ((own @ self.basis) * weights[d:]) @ self.basis.T
        return found

    def variance_of_noise(self, weights: Floats) -> Floats:
        """Return (r,) the variance of each row's noise."""
        found = np.ones(self.n_rows)
        found[self.place] /= 1.0 - weights[: len(self.place)]
        return found

    def leverage(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row that weights (d + q,) take: of those in the run."""
        found, d = np.zeros(self.n_rows), len(self.place)
        found[self.place] = weights[:d] + self.basis**2 @ weights[d:]
        return found

    def weights(self, size: float) -> Floats:
        """Return (d + q,) by how much so many noises more make inverse variances smaller: τ² / (1 + τ²) of all rows.

        Along what lasts as well, to 1 / (1 + τ² + λ) from 1 / (1 + λ): by what that differs from τ² / (1 + τ²).
        """
        more = size**2 / (1.0 + size**2)
        along = 1.0 / (1.0 + self.known) - 1.0 / (1.0 + size**2 + self.known)
        return np.append(np.full(len(self.place), more), along - more)

    def log_determinant(self, size: float) -> float:
        """Return log |V|, less that without more noise."""
        plain = (self.free - len(self.known)) * np.log1p(size**2)
        return float(plain + np.sum(np.log1p(size**2 / (1.0 + self.known))))


@dataclass(frozen=True)
class OffRun:
    """How a run alone may be off."""

    run: int
    """Its number."""
    place: Integers
    """(p,) positions of its whitened rows."""
    moved: Floats
    """(p, d) directions by which it may be off, together of rms one."""

    def rows(self, n_rows: int) -> Floats:
        """Return the directions (d, r) among the whitened rows of all runs."""
        found = np.zeros((self.moved.shape[1], n_rows))
        found[:, self.place] = self.moved.T
        return found


def _joined(parts: Sequence[tuple[Integers, Floats, Floats]]) -> tuple[Integers, Floats, Floats]:
    """Return the rows of a run's components and their directions together, those of most variance first."""
    place, variance = (np.concatenate([part[k] for part in parts]) for k in (0, 2))
    whole, row, column = np.zeros((len(place), len(variance))), 0, 0
    for _, basis, _ in parts:
        whole[row : row + len(basis), column : column + basis.shape[1]] = basis
        row, column = row + len(basis), column + basis.shape[1]
    order = np.argsort(-variance, kind="stable")
    return place, whole[:, order], variance[order]


def off_by_run(of_loads: Discrepancy, of_time: Discrepancy, flat: Floats) -> Iterator[OffRun]:
    """Give how each run alone may be off.

    Not of absolute places, of which each row is a run: a row that is off is a reading.

    Parameters
    ----------
    of_loads, of_time : how runs answer their loads and wander; a run that is off does both, as far as it likes.
    flat : (p, r) columns of what all runs share and nothing is known of: a run that is off says nothing of it.
    """
    walks = of_time.moves
    for run, (place, answer) in of_loads.moves.items():
        if run not in walks:
            continue
        walk = walks[run][1]
        loads = answer / np.maximum(np.linalg.norm(answer, axis=0), 1e-300)
        # of a long run the walk's first waves alone, next to all that it can answer; a short one moves in any way
        moved = answer[:, :MOST_OF_RUN]
        if moved.shape[1] < MOST_OF_RUN:
            basis, size, _ = thin_svd(walk - loads @ (loads.T @ walk))
            waves = (basis * size)[:, size > LEAST_DIRECTION * walk.max(initial=0.0)]
            moved = np.column_stack([moved, waves])[:, :MOST_OF_RUN]
        if moved.any():
            moved = np.column_stack([moved, _beyond(flat[:, place].T, moved)])
            yield OffRun(run, place, moved * np.sqrt(len(place) / np.sum(moved**2)))


def _beyond(shared: Floats, moved: Floats) -> Floats:
    """Return (r, q) what shared columns (r, p), as large as all that moves a run, make beyond that, as far as it shows.

    It shows where a run is off by thousands of noises: in another unit it would else decide of what all runs share.
    """
    size = float(np.linalg.norm(moved))
    basis, _ = np.linalg.qr(moved)
    left = shared * size / np.maximum(np.linalg.norm(shared, axis=0), 1e-300)
    axes, values, _ = thin_svd(left - basis @ (basis.T @ left))
    return np.asarray((axes * values)[:, values * RUN_SIZES[-1] > size])


def _unit_loads(wrench: Floats) -> list[Floats]:
    """Return the components (n,) of the loads, together of size one where the load is largest."""
    parts = []
    for part in (wrench[:3], wrench[3:]):
        most = float(np.sqrt(np.max(np.sum(part**2, axis=0), initial=0.0)))
        if most > 0.0:
            parts.append(part / most)
    return [row / np.sqrt(len(parts)) for part in parts for row in part]
