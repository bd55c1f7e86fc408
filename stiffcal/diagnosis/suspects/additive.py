"""Whether what is left of a run is one reading that is off, or a step from one state on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from stiffcal.diagnosis.suspects.whitened_runs import WhitenedRuns
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.readings.row_layout import TRANSLATION


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
    """What its free size and place cost against a mistake that has none, as a difference of squared misfits."""


def best_offset(whitened: WhitenedRuns, run: int, left_out: Sequence[int]) -> Offset | None:
    """Return the offset that explains most of a run's deleted residual, None where the run has no reading.

    Parameters
    ----------
    whitened : the readings. run : which run. left_out : runs that, with ``run``, are left out of the parameters.
    """
    run_states = whitened.members[run]
    if not len(run_states):
        return None
    normal_matrix, parameters = whitened.blocks.without(sorted({*left_out, run}))
    # the last of the whitened rows is the residual, those before it are the parameters' columns
    columns = np.einsum("pq,pmn->qmn", whitened.basis.combination, whitened.rows[:-1][:, :, run_states])
    m, k = whitened.rows.shape[1], len(run_states)
    residual = (whitened.rows[-1][:, run_states] - np.einsum("q,qmn->mn", parameters, columns)).ravel()
    flat = columns.reshape(len(columns), -1)
    inverse = np.linalg.inv(normal_matrix + whitened.blocks.gram[run])
    observations = whitened.data.subset(run_states)
    projection = Projection.of(observations, whitened.projection.whitening.subset(run_states))
    best: Offset | None = None
    tried = [(state, False) for state in range(k)] + [(state, True) for state in range(1, k - 1)]
    for state, step in tried:
        later = np.arange(k) >= state if step else np.arange(k) == state
        unit = projection.rows(np.where(later, np.eye(m)[:, :, None], 0.0))
        # weighted with the inverse covariance of the deleted residual, the parameters' uncertainty included (Woodbury)
        weighted = unit - (unit @ flat.T) @ inverse @ flat
        right_side, normal_of_offset = weighted @ residual, weighted @ unit.T
        offset, _, rank, _ = np.linalg.lstsq(normal_of_offset, right_side, rcond=1e-9)
        gain = float(right_side @ offset)
        if rank and (best is None or gain > best.gain):
            translation = whitened.data.kind == TRANSLATION
            length = float(np.linalg.norm(offset[translation])) if translation.any() else np.nan
            # The offset's free components: log-determinant of a normal prior with g = gain / rank times the estimate's
            # covariance (a g-prior, Zellner 1986, its g from the data); its place: −2 log of one among those tried.
            penalty = rank * log(1.0 + gain / rank) + 2.0 * log(len(tried))
            best = Offset(int(run_states[state]), step, length, gain, int(rank), penalty)
    return best
