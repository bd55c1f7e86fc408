"""How sure a choice among candidates is: repeated with poses drawn anew, and without each group of poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scan import ROUNDING, Scan, Trial
from stiffcal.diagnosis.thresholds import RESAMPLINGS


def first_least(errors: Floats) -> Integers:
    """Return (f,) which of errors (t, f) is least, the first of those that differ by rounding only."""
    least = errors.min(axis=0)
    return np.asarray(np.argmax(errors <= least + ROUNDING * np.abs(least), axis=0), dtype=np.int64)


def confidence(scan: Scan, seed: int = 0, among: Sequence[Trial] | None = None) -> dict[str, float]:
    """Return how often each candidate comes first when poses are drawn anew, with replacement.

    Parameters
    ----------
    scan : the scan.
    seed : of the resampling.
    among : the candidates that take part; all of the scan's where None.
    """
    trials = scan.trials if among is None else among
    if not trials:
        return {}
    rng = np.random.default_rng(seed)
    n_folds = len(scan.folds)
    weights = rng.multinomial(n_folds, np.full(n_folds, 1.0 / n_folds), size=RESAMPLINGS)
    errors = np.stack([trial.score.heldout for trial in trials]) @ weights.T
    first = np.bincount(first_least(errors), minlength=len(trials)) / RESAMPLINGS
    return {trial.candidate.name: float(share) for trial, share in zip(trials, first, strict=True)}


def confidence_by_class(scan: Scan, seed: int = 0) -> dict[str, float]:
    """Return how often each candidate comes first, simple effects among themselves.

    General laws (a joint's whole compliance) hold many effects as special cases and are named only where no simple
    effect comes near: they would else come first wherever a simple one is missing.
    """
    simple = [trial for trial in scan.trials if not trial.candidate.effect.general]
    return confidence(scan, seed) | confidence(scan, seed, among=simple)


def choice_without_each_group(scan: Scan) -> Integers:
    """Return (G,) which candidate the poses outside each group choose: 0 the present model, k the scan's trial k - 1.

    The present model takes part in the choice: where nothing helps, nothing is chosen.
    """
    scores = [scan.base, *(trial.score for trial in scan.trials)]
    return first_least(np.stack([score.nested.sum(axis=1) - np.diagonal(score.nested) for score in scores]))


def chosen_in_every_fold(scan: Scan) -> Floats:
    """Return (G,) held-out squares with the choice of the candidate repeated in every group of poses."""
    scores = [scan.base, *(trial.score for trial in scan.trials)]
    chosen = choice_without_each_group(scan)
    return np.array([scores[number].nested[group, group] for group, number in enumerate(chosen)])
