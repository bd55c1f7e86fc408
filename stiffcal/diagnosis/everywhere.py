"""One effect at all joints at once, where no effect at any one joint can be named.

Errors of like size at every joint, of six encoders for instance, are each too small to be named and lower the error in
poses left out together. Such a set of terms is no evidence of a cause: it is offered where the search ends unexplained
and names nothing, and the verdict stays. It is judged by the rule for single effects: the error in poses left out, the
choice of the effect repeated in every fold, and the probability by chance with all of its parameters counted; and next
to that in the schemes in which absolute places are judged: the error in whole regions left out has to fall by as much
again, and that in poses left out at random, which is much like the first, not to rise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.choosing import first_least
from stiffcal.diagnosis.everywhere_results import EffectEverywhere, ErrorLeftOut
from stiffcal.diagnosis.judge import f_tail, rms_reduction
from stiffcal.diagnosis.load_scan import LoadScan
from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.search_results import Search
from stiffcal.diagnosis.thresholds import FAMILY_P, LEAST_FALL, STANDARD_ERRORS
from stiffcal.diagnosis.together import as_one, laws_at_joints
from stiffcal.identification.fit import Fit
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place
from stiffcal.model.no_balance import NoBalanceError
from stiffcal.model.summary import Where
from stiffcal.validation.distances import squared_distances, standard_errors_of_fall, summary_of
from stiffcal.validation.heldout import left_out_residuals, search_folds
from stiffcal.validation.region_folds import random_folds, region_folds

LEAST_JOINTS = 2


def effect_everywhere(bench: LoadSearchContext, search: Search) -> EffectEverywhere | None:
    """Return the effect that at all joints together lowers the error of absolute places; None where none does.

    Parameters
    ----------
    bench : the context in which the model with it is fitted.
    search : of the present model, which may hold other such sets. None is returned as well where it named anything, or
        left nothing unexplained.
    """
    scan = search.first
    if not search.unexplained or search.found or search.undecided or not scan.fit.data.absolute.all():
        return None
    sets = _sets(scan)
    if not sets:
        return None
    errors = np.stack([one.score.nested.sum(axis=1) - np.diagonal(one.score.nested) for one in sets])
    best = min(range(len(sets)), key=lambda k: float(np.sum(sets[k].score.heldout)))
    if not _supported(scan, sets, best, first_least(errors)):
        return None
    effect, joints = sets[best].candidate.effect, sets[best].candidate.place.joints
    added = tuple(PlacedEffect(effect, Place("joints", (joint,))) for joint in joints)
    try:
        fit = bench.fit(replace(scan.fit.robot, placed=(*scan.fit.robot.placed, *added)))
    except (NoBalanceError, ArithmeticError):
        return None
    values = [placed for placed in fit.robot.placed if placed.effect.name == effect.name]
    if any(placed.effect.impossible(placed.values) is not None for placed in values):
        return None
    random, region = (_error_left_out(scan.fit, fit, folds(fit.data)) for folds in (random_folds, region_folds))
    if region.standard_errors <= STANDARD_ERRORS or random.standard_errors <= 0.0:
        return None
    return EffectEverywhere(
        effect=effect.name,
        where=Where.of(sets[best].candidate.place),
        n_parameters=sets[best].candidate.n_parameters,
        heldout_random=random,
        heldout_region=region,
    )


def _sets(scan: LoadScan) -> list[Trial]:
    """Return every effect of single joints that the model holds at none, at all joints at which it shows."""
    present = {placed.effect.name for placed in scan.fit.robot.placed}
    return [
        as_one(scan, list(trials.values()))
        for law, trials in laws_at_joints(scan).items()
        if law not in present and len(trials) >= LEAST_JOINTS
    ]


def _supported(scan: LoadScan, sets: Sequence[Trial], best: int, choice: Integers) -> bool:
    """Return whether the best set is supported, its choice among the sets repeated without each group of poses."""
    one = sets[best]
    fall, errors = rms_reduction(scan.base.heldout, one.score.heldout, one.score.prediction_change, scan.dof)
    after = np.array([sets[number].score.nested[group, group] for group, number in enumerate(choice)])
    before, by_group = np.diagonal(scan.base.nested), np.bincount(scan.groups, weights=one.score.prediction_change)
    repeated, _ = rms_reduction(before, after, by_group.astype(np.float64), scan.dof)
    # what is left is no noise: it is the error itself of which a hundredth counts
    least = LEAST_FALL * max(1.0, float(np.sqrt(scan.base.heldout.sum() / scan.dof)))
    return min(fall, repeated) > least and errors > STANDARD_ERRORS and _by_chance(scan, one) < FAMILY_P


def _by_chance(scan: LoadScan, one: Trial) -> float:
    """Return the probability of so large a fall of the fit's squares by chance, all that was tried counted."""
    count, squares = one.candidate.n_parameters, one.score.sum_of_squares
    residual_dof = float(scan.residual_dof - count)
    if residual_dof <= 0.0:
        return 1.0
    known = np.inf if scan.fit.noise is None else scan.fit.noise.dof
    drop = max(scan.base.sum_of_squares - squares, 0.0) / max(1.0, squares / residual_dof) / count
    return scan.n_tried * f_tail(drop, count, min(residual_dof, known))


def _error_left_out(before: Fit, after: Fit, folds: Integers) -> ErrorLeftOut:
    """Return the mean distance in what is left out by one scheme, without and with the effect."""
    residuals = [left_out_residuals(fit, folds).residual for fit in (before, after)]
    means = [summary_of(residual, before.data) for residual in residuals]
    squares: list[Floats] = [squared_distances(residual, before.data) for residual in residuals]
    return ErrorLeftOut(
        before=0.0 if means[0] is None else means[0].mean,
        after=0.0 if means[1] is None else means[1].mean,
        standard_errors=standard_errors_of_fall(squares[0], squares[1], search_folds(before.data)),
    )


def everywhere_in_words(found: EffectEverywhere) -> str:
    """Return what the effect at all joints does to the error, and that it names no cause."""
    joints_text = ", ".join(map(str, found.where.joints or []))
    region, random = found.heldout_region, found.heldout_random
    return (
        f"{found.effect} of joints {joints_text} together ({found.n_parameters} parameters) lowers the mean distance "
        f"from {1e3 * region.before:.3f} to {1e3 * region.after:.3f} mm in held-out regions and from "
        f"{1e3 * random.before:.3f} to {1e3 * random.after:.3f} mm in poses held out at random: a better calibration, "
        "not a cause; it can be named at no single joint"
    )
