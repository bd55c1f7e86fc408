"""Whitened rows with each run's offset taken out: the space in which regressors are compared."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.constants import StretchConstants
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.run_offsets import run_offsets

# Numbers that are whitened together: 8 MB, of which there are a handful of copies on the way.
NUMBERS_AT_ONCE = 1 << 20


@dataclass(frozen=True)
class Projection:
    """Turns displacements (k, m, n) into whitened rows (k, m · n), run offsets eliminated."""

    data: Observations
    """The observations."""
    whitening: Whitening
    """Their noise."""
    offsets: StretchConstants
    """Of their runs."""

    @classmethod
    def of(cls, data: Observations, whitening: Whitening) -> Projection:
        """Prepare the projection."""
        return cls(data, whitening, run_offsets(data, whitening))

    @property
    def n_constants(self) -> int:
        """How many components of runs' offsets are estimated: those that a run measured."""
        return self.offsets.n_free

    @property
    def scale(self) -> Floats:
        """(m, n) one over the standard uncertainty of each reading; 0 where nothing was read."""
        return self.whitening.scale

    @cached_property
    def free(self) -> Floats:
        """(m, n) share of each reading that runs' offsets leave free; 0 where nothing was read."""
        return np.where(self.data.measured_mask, 1.0 - self.offsets.leverage(), 0.0)

    @property
    def independent(self) -> bool:
        """Whether what moves one component shows in rows of that alone."""
        return self.whitening.diagonal

    def centred(self, stack: Floats) -> Floats:
        """Return (k, m, n) with each run's weighted mean taken out (unchanged where runs carry no offset)."""
        stack = np.where(self.data.measured_mask, stack, 0.0)
        centred = self.offsets.centred(stack, self.whitening.apply(stack))
        return np.where(self.data.measured_mask, centred, 0.0)

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) whitened rows."""
        if not len(stack):
            return np.zeros((0, stack.shape[1] * stack.shape[2]))
        step = max(1, NUMBERS_AT_ONCE // max(stack[:1].size, 1))
        if len(stack) > step:
            result = np.empty((len(stack), stack[0].size))
            for start in range(0, len(stack), step):
                result[start : start + step] = self.rows(stack[start : start + step])
            return result
        white = self.whitening.apply(np.where(self.data.measured_mask, stack, 0.0))
        return self.offsets.rows(white).reshape(len(stack), -1)

    def unwhitened(self, rows: Floats) -> Floats:
        """Return (m, n) displacements, run offsets taken out, of whitened rows (m · n); 0 where none was measured."""
        white = rows.reshape(self.data.measured.shape)
        if self._inverse is None:
            scale = self.whitening.scale
            return np.where(scale > 0.0, white / np.where(scale > 0.0, scale, 1.0), 0.0)
        white = np.where(self.data.measured_mask, white, 0.0)
        return np.asarray(np.einsum("nab,bn->an", self._inverse, white))

    @cached_property
    def _inverse(self) -> Floats | None:
        """(n, m, m) what undoes the whitening of each state, 1 for what was not measured; None where it is diagonal."""
        lower, missing = self.whitening.lower, ~self.data.measured_mask
        if lower is None:
            return None
        return np.asarray(np.linalg.inv(np.moveaxis(lower, -1, 0) + missing.T[:, :, None] * np.eye(len(missing))))
