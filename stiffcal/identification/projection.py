"""Whitened rows with each run's offset taken out: the space in which regressors are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.least_squares import run_edges
from stiffcal.identification.noise import Whitening
from stiffcal.identification.observation import Observations

# Numbers that are whitened together: 8 MB, of which there are a handful of copies on the way.
NUMBERS_AT_ONCE = 1 << 20


@dataclass(frozen=True)
class Projection:
    """Turns displacements (k, m, n) into whitened rows (k, m · n), run offsets eliminated."""

    data: Observations
    """The observations."""
    whitening: Whitening
    """Their noise."""
    edges: Integers
    """(R,) index of each run's first state."""
    counts: Integers
    """(R,) number of each run's states."""
    precision: Floats | None
    """(m, m, n) inverse covariances, None where diagonal."""
    inverse_total: Floats
    """(R, m, m) inverse of each run's summed precision (m, R reciprocals where diagonal)."""
    offsets: tuple[tuple[Integers | slice, Floats], ...]
    """Per length L of the runs that carry an offset: which states, and (R_L, m · L, m) orthonormal whitened offsets of
    their runs; empty where runs carry none.
    """

    @classmethod
    def of(cls, data: Observations, whitening: Whitening) -> Projection:
        """Prepare the projection."""
        edges = run_edges(data.run)
        counts = np.diff(np.append(edges, data.n_states))
        offsets = tuple(_offsets(data, whitening, edges, counts)) if data.free_offset else ()
        if whitening.diagonal:
            total = np.add.reduceat(whitening.scale**2, edges, axis=1)
            inverse = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
            return cls(data, whitening, edges, counts, None, inverse, offsets)
        precision = whitening.precision()
        sums = np.moveaxis(np.add.reduceat(precision, edges, axis=2), -1, 0)
        return cls(data, whitening, edges, counts, precision, np.linalg.pinv(sums, hermitian=True), offsets)

    @property
    def n_constants(self) -> int:
        """How many components of runs' offsets are estimated: those that a run measured."""
        measured = np.add.reduceat(self.data.measured_mask.astype(np.int64), self.edges, axis=1) > 0
        return int(np.count_nonzero(measured & self.data.carries_offset[self.edges]))

    def centred(self, stack: Floats) -> Floats:
        """Return (k, m, n) with each run's weighted mean taken out (unchanged where runs carry no offset)."""
        stack = np.where(self.data.measured_mask, stack, 0.0)
        if not self.data.free_offset:
            return stack
        if self.precision is None:
            weighted = np.add.reduceat(stack * self.whitening.scale**2, self.edges, axis=2)
            mean = weighted * self.inverse_total
        else:
            weighted = np.zeros_like(stack)
            for a in range(stack.shape[1]):
                for b in range(stack.shape[1]):
                    weighted[:, a] += self.precision[a, b] * stack[:, b]
            sums = np.add.reduceat(weighted, self.edges, axis=2)
            mean = np.einsum("rab,kbr->kar", self.inverse_total, sums)
        mean = np.repeat(np.where(self.data.carries_offset[self.edges], mean, 0.0), self.counts, axis=2)
        return np.where(self.data.measured_mask, stack - mean, 0.0)

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) whitened rows."""
        step = max(1, NUMBERS_AT_ONCE // max(stack[:1].size, 1))
        if len(stack) > step:
            result = np.empty((len(stack), stack[0].size))
            for start in range(0, len(stack), step):
                result[start : start + step] = self.rows(stack[start : start + step])
            return result
        white = self.whitening.apply(np.where(self.data.measured_mask, stack, 0.0))
        k, m, _ = white.shape
        for states, basis in self.offsets:
            n_runs = len(basis)
            own = white[:, :, states].reshape(k, m, n_runs, -1).transpose(2, 0, 1, 3).reshape(n_runs, k, -1)
            own = own - (own @ basis) @ basis.transpose(0, 2, 1)
            white[:, :, states] = own.reshape(n_runs, k, m, -1).transpose(1, 2, 0, 3).reshape(k, m, -1)
        return np.asarray(white.reshape(k, -1))

    def unwhitened(self, rows: Floats) -> Floats:
        """Return (m, n) displacements, run offsets taken out, of whitened rows (m · n); 0 where none was measured."""
        white, lower = rows.reshape(self.data.measured.shape), self.whitening.lower
        if lower is None:
            scale = self.whitening.scale
            return np.where(scale > 0.0, white / np.where(scale > 0.0, scale, 1.0), 0.0)
        factor = np.moveaxis(lower, -1, 0) + np.apply_along_axis(np.diag, 1, (~self.data.measured_mask).T.astype(float))
        white = np.where(self.data.measured_mask, white, 0.0)
        return np.asarray(np.linalg.solve(factor, white.T[..., None])[..., 0].T)


def _offsets(
    data: Observations, whitening: Whitening, edges: Integers, counts: Integers
) -> Iterator[tuple[Integers | slice, Floats]]:
    """Yield, for each length of run, its states and an orthonormal basis of what the runs' offsets can make."""
    m = len(data.measured)
    unit = whitening.apply(np.where(data.measured_mask, np.eye(m)[:, :, None], 0.0))
    with_offset = data.carries_offset[edges]
    for length in np.unique(counts[with_offset]):
        picked = np.flatnonzero((counts == length) & with_offset)
        states: Integers | slice = (edges[picked][:, None] + np.arange(length)).ravel()
        if len(picked) == len(counts):
            states = slice(0, data.n_states)
        own = unit[:, :, states].reshape(m, m, len(picked), -1).transpose(2, 1, 3, 0).reshape(len(picked), -1, m)
        # A component that a run never measured has no offset there.
        value, vector = np.linalg.eigh(own.transpose(0, 2, 1) @ own)
        known = value > 1e-12 * value[:, -1:]
        scale = np.where(known, 1.0 / np.sqrt(np.where(known, value, 1.0)), 0.0)
        yield states, own @ (vector * scale[:, None, :])
