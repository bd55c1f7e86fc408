"""A name that stands alone is compared again, in the weights of the model that holds it.

The scan that finds an effect weighs readings by the model without it, in which the wrench's noise reaches the readings
through plain springs. A play or a knee carries far more of that noise where it is crossed: the scan takes these
readings for better than they are, and one of two laws that the data leave open may seem ahead by more than two standard
errors over poses. So those that come next are compared again in the weights of the fit with the effect.
"""

from __future__ import annotations

from dataclasses import replace

from stiffcal.diagnosis.judge import alike, judge, possible_values, same_within_noise
from stiffcal.diagnosis.naming import look_alikes
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.search_context import SearchContext
from stiffcal.diagnosis.search_results import F, MissingEffect, S
from stiffcal.diagnosis.slips import is_slip

# Of the candidates behind the named one, so many are compared again: in the scan's weights the others are far behind.
COMPARED = 8


def with_alike_in_own_weights(
    bench: SearchContext[S, F], look: S, final: S, missing_effect: MissingEffect
) -> MissingEffect:
    """Return a missing effect with the alternatives that the weights of the fit with it show.

    Parameters
    ----------
    bench : data, catalogue and settings.
    look : the look at the model without the effect.
    final : the look at the model with all that is missing.
    missing_effect : as found; returned as it is where it has alternatives or rivals already, or is a general law.
    """
    named = missing_effect.candidate
    stands_alone = not (missing_effect.alternatives or missing_effect.rivals)
    if not stands_alone or named.effect.general or named.effect.name in bench.basic or is_slip(named.effect):
        return missing_effect
    behind = [trial.candidate for trial in look.trials if trial.candidate.name != named.name and _is_simple(trial)]
    scan = bench.scan(bench.fit_of(look), [named, *behind[:COMPARED]], bench.fit_of(final))
    own = next((trial for trial in scan.trials if trial.candidate.name == named.name), None)
    if own is None:
        return missing_effect
    near = [
        trial
        for trial in scan.trials
        if trial is not own
        and possible_values(scan, trial)
        and (same_within_noise(scan, trial, own) or (judge(scan, trial).supported and alike(scan, trial, own)))
    ]
    alternatives, cosines = look_alikes(scan, near, own)
    return replace(missing_effect, alternatives=alternatives, cosines=cosines)


def _is_simple(trial: Trial) -> bool:
    return not (trial.candidate.effect.general or is_slip(trial.candidate.effect))
