"""Effects that fit all poses where none can be judged in poses left out: too few poses to decide between them.

Leave one pose out of few, and what is left no longer determines an effect with several amplitudes: its error there is
large although the effect may be the very one. Such a set is no explanation, but it is not “none of these” either.
"""

from __future__ import annotations

import numpy as np

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.judge import f_tail, possible_values
from stiffcal.diagnosis.scan import Scan, Trial, ranked_error
from stiffcal.diagnosis.slips import is_slip
from stiffcal.diagnosis.thresholds import ADEQUATE_RATIO, LACK_OF_FIT_P
from stiffcal.model.effect import ParameterRole


def sufficient_alone(scan: Scan) -> tuple[Candidate, ...]:
    """Return the effects of which each alone, all else refitted, leaves no more than noise of all poses together.

    Fewest parameters first. Held against the noise like a model (`judge.lack_of_fit`), in the fit; empty where the
    noise is not known. A slip does not count: one in some run is always to be had.
    """
    if scan.fit.noise is None:
        return ()
    known = scan.fit.noise.dof
    if _is_noise(scan.base.sum_of_squares, float(scan.residual_dof), known):
        # What is left is not more than the scatter of repeats: it is something else about it that is wrong.
        return ()
    sufficient = [trial for trial in scan.trials if _fits(scan, trial, known)]
    sufficient.sort(key=lambda trial: (trial.candidate.n_parameters, ranked_error(trial)))
    return tuple(trial.candidate for trial in sufficient)


def _fits(scan: Scan, trial: Trial, known: float) -> bool:
    if is_slip(trial.candidate.effect) or not possible_values(scan, trial):
        return False
    shapes = sum(1 for spec in trial.candidate.effect.parameters if spec.role is ParameterRole.NONLINEAR)
    return _is_noise(
        trial.score.sum_of_squares, float(scan.residual_dof - len(trial.regressor.symbols) - shapes), known
    )


def _is_noise(squares: float, dof: float, known: float) -> bool:
    """Return whether whitened squares with so many degrees of freedom may be noise known with ``known``."""
    if dof <= 0.0:
        return False
    return bool(np.sqrt(squares / dof) <= ADEQUATE_RATIO or f_tail(squares / dof, dof, known) > LACK_OF_FIT_P)
