"""Whether what is left of a run is one reading that is off, or a step from one state on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from stiffcal.diagnosis.suspects.bench import WhitenedRuns
from stiffcal.identification.projection import Projection
from stiffcal.identification.rows import TRANSLATION


@dataclass(frozen=True)
class Offset:
    """A displacement that one state of a run has beyond the others, or all states from one on."""

    state: int
    """Its index among the n states of the readings."""
    step: bool
    """True where all later states of the run have the displacement too."""
    size_m: float
    """Its length, NaN where no translation is measured."""
    gain: float
    """By how much it lowers the run's squared misfit."""
    dof: int
    """How many components it has."""
    penalty: float
    """How much less likely it is than a mistake without a free size, as a difference of squared misfits."""


def best_offset(whitened: WhitenedRuns, run: int, left_out: Sequence[int]) -> Offset | None:
    """Return the offset that explains most of a run's deleted residual, None where the run has no reading.

    Parameters
    ----------
    whitened : the readings. run : which run. left_out : runs that, with ``run``, are left out of the parameters.
    """
    run_states = whitened.members[run]
    if not len(run_states):
        return None
    total, x = whitened.blocks.without(sorted({*left_out, run}))
    columns = np.einsum("pq,pmn->qmn", whitened.basis.combination, whitened.rows[:-1][:, :, run_states])
    m, k = whitened.rows.shape[1], len(run_states)
    residual = (whitened.rows[-1][:, run_states] - np.einsum("q,qmn->mn", x, columns)).ravel()
    flat = columns.reshape(len(columns), -1)
    inverse = np.linalg.inv(total + whitened.blocks.gram[run])
    observations = whitened.data.subset(run_states)
    projection = Projection.of(observations, whitened.projection.whitening.subset(run_states))
    best: Offset | None = None
    tried = [(state, False) for state in range(k)] + [(state, True) for state in range(1, k - 1)]
    for state, step in tried:
        later = np.arange(k) >= state if step else np.arange(k) == state
        unit = projection.rows(np.where(later, np.eye(m)[:, :, None], 0.0))
        # weighed with the inverse covariance of the deleted residual, what the others leave open of x included
        weighed = unit - (unit @ flat.T) @ inverse @ flat
        toward, gram = weighed @ residual, weighed @ unit.T
        size, _, rank, _ = np.linalg.lstsq(gram, toward, rcond=1e-9)
        gain = float(toward @ size)
        if rank and (best is None or gain > best.gain):
            translation = whitened.data.kind == TRANSLATION
            length = float(np.linalg.norm(size[translation])) if translation.any() else np.nan
            penalty = rank * log(1.0 + gain / rank) + 2.0 * log(len(tried))
            best = Offset(int(run_states[state]), step, length, gain, int(rank), penalty)
    return best
