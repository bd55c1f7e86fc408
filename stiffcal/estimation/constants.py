"""Free constants of stretches of readings, taken out exactly: what they can make is projected out of whitened rows.

The rest is that of generalised least squares with the constants among the unknowns (Frisch and Waugh 1933).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers

# Squared length, of the largest, below which constants together make rounding.
LEAST = 1e-12
# Of forty columns and six components a third of a megabyte: what is made of them on the way stays in the cache.
STATES_AT_ONCE = 200


def orthonormal(unit: Floats) -> tuple[Floats, Floats]:
    """Return an orthonormal basis (…, r, c) of what constants can make, and (…, c, c) the constants of each direction.

    Zeros stand for directions that no row shows.

    Parameters
    ----------
    unit : (…, r, c) what one of each of c constants makes in r rows of unit variance.
    """
    value, vector = np.linalg.eigh(np.swapaxes(unit, -1, -2) @ unit)
    known = value > LEAST * value[..., -1:]
    constants = vector * np.where(known, 1.0 / np.sqrt(np.where(known, value, 1.0)), 0.0)[..., None, :]
    return unit @ constants, constants


def without_constants(rows: Floats, unit: Floats) -> Floats:
    """Return rows (…, k, r) of unit variance with constants taken out; ``unit`` (…, r, c) as of `orthonormal`."""
    basis, _ = orthonormal(unit)
    return np.asarray(rows - (rows @ basis) @ np.swapaxes(basis, -1, -2))


def stretches(number: Integers) -> Integers:
    """Return the first index of each stretch of equal numbers."""
    return np.concatenate([[0], np.flatnonzero(np.diff(number)) + 1]).astype(np.int64)


@dataclass(frozen=True)
class StretchConstants:
    """Constants of m components in stretches of n states."""

    edges: Integers
    """(R,) index of each stretch's first state."""
    carry: Booleans
    """(R,) True for stretches that have free constants."""
    scale: Floats
    """(m, n) 1/σ, where components are independent; zero where nothing was read."""
    lower: Floats | None
    """(m, m, n) inverses of the covariances' Cholesky factors, None where components are independent."""

    @property
    def counts(self) -> Integers:
        """(R,) number of each stretch's states."""
        return np.diff(np.append(self.edges, self.scale.shape[1]))

    @cached_property
    def n_free(self) -> int:
        """How many constants are free: of the components that a stretch has readings of."""
        weight = self.scale**2 if self.lower is None else np.sum(self.lower**2, axis=0)
        return int(np.count_nonzero((np.add.reduceat(weight, self.edges, axis=1) > 0.0) & self.carry))

    def leverage(self) -> Floats:
        """Return (m, n) the share of each whitened reading's variance that constants take."""
        share = np.zeros(self.scale.shape)
        if self.lower is None:
            total = np.add.reduceat(self.scale**2, self.edges, axis=1)
            free = np.where(self.carry & (total > 0.0), 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
            return np.asarray(self.scale**2 * np.repeat(free, self.counts, axis=1))
        for alike in self._alike:
            own = np.sum(alike.basis**2, axis=2)
            share[:, alike.states] = own.reshape(len(own), len(share), -1).transpose(1, 0, 2).reshape(len(share), -1)
        return share

    def rows(self, white: Floats) -> Floats:
        """Return whitened (k, m, n) with what constants can make taken out; ``white`` itself may be changed."""
        if not self.carry.any():
            return white
        if self.lower is None:
            return np.asarray(white - self.scale * np.repeat(self._means(white), self.counts, axis=2))
        for alike, own in self._parts(white):
            taken = (own @ alike.basis) @ np.swapaxes(alike.basis, 1, 2)
            k, m, _ = white.shape
            white[:, :, alike.states] -= taken.reshape(len(own), k, m, -1).transpose(1, 2, 0, 3).reshape(k, m, -1)
        return white

    def centred(self, stack: Floats, white: Floats) -> Floats:
        """Return (k, m, n) less its constants of least squares; ``white`` is the same, whitened."""
        if not self.carry.any():
            return stack
        if self.lower is None:
            mean = self._means(white)
        else:
            mean = np.zeros((*stack.shape[:2], len(self.edges)))
            for alike, own in self._parts(white):
                found = (own @ alike.basis) @ np.swapaxes(alike.constants, 1, 2)
                mean[:, :, alike.number] = np.moveaxis(found, 0, -1)
        return np.asarray(stack - np.repeat(mean, self.counts, axis=2))

    def _means(self, white: Floats) -> Floats:
        """Return (k, m, R) weighted means of independent components, zero for stretches without constants."""
        total = np.add.reduceat(self.scale**2, self.edges, axis=1)
        share = np.where(self.carry & (total > 0.0), 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
        return np.asarray(np.add.reduceat(white * self.scale, self.edges, axis=2) * share)

    @cached_property
    def _alike(self) -> tuple[_Alike, ...]:
        if self.lower is None:
            return ()
        found = []
        for length in np.unique(self.counts[self.carry]):
            every = np.flatnonzero((self.counts == length) & self.carry)
            for number in np.array_split(every, min(len(every), -(-len(every) * length // STATES_AT_ONCE))):
                each = (self.edges[number][:, None] + np.arange(length)).ravel()
                first, last = int(each[0]), int(each[-1])
                states = slice(first, last + 1) if last - first == len(each) - 1 else each
                unit = _stretches_first(np.swapaxes(self.lower[:, :, states], 0, 1), len(number))
                found.append(_Alike(number, states, *orthonormal(np.swapaxes(unit, 1, 2))))
        return tuple(found)

    def _parts(self, white: Floats) -> Iterator[tuple[_Alike, Floats]]:
        """Yield some stretches of one length after the others, with their whitened rows (R', k, m · L)."""
        for alike in self._alike:
            yield alike, _stretches_first(white[:, :, alike.states], len(alike.number))


@dataclass(frozen=True)
class _Alike:
    """Some stretches of one length L that have constants."""

    number: Integers
    """(R',) which stretches."""
    states: Integers | slice
    """Their states."""
    basis: Floats
    """(R', m · L, m) as of `orthonormal`."""
    constants: Floats
    """(R', m, m) the same."""


def _stretches_first(rows: Floats, n_stretches: int) -> Floats:
    """Return (R', k, m · L) of (k, m, R' · L)."""
    k, m, _ = rows.shape
    return rows.reshape(k, m, n_stretches, -1).transpose(2, 0, 1, 3).reshape(n_stretches, k, -1)
