"""Whether an effect of the catalogue explains a suspect as well as a fault of its run does."""

from __future__ import annotations

import numpy as np

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.search_context import without
from stiffcal.diagnosis.search_results import Search
from stiffcal.diagnosis.suspects.bench import Bench
from stiffcal.diagnosis.suspects.find import CURED, CURED_AGAINST_OTHERS, Suspicion
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Settings, identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.equilibrium import NoBalanceError


def explaining_effects(
    suspicion: Suspicion, states: LoadStates, search: Search, settings: Settings
) -> dict[int, tuple[Candidate, ...]]:
    """Return the effects with which a suspect's run agrees with the others, by the run's number.

    The measure is that of a cure: the run's deleted residual with the effects in the model, against the noise and
    against the worst of the runs that are no suspects. An effect that shows in that run alone takes as many degrees of
    freedom from it as it has amplitudes.

    Parameters
    ----------
    suspicion : what was found without these effects. states : load states with the suspects among them.
    search : of these states. settings : of its fits.
    """
    effects = tuple(missing_effect.candidate for missing_effect in search.tried)
    runs = {suspect.run for suspect in suspicion.suspects} & set(np.unique(states.run[states.used]).tolist())
    if not effects or not runs:
        return {}
    explained = _agreeing(runs, suspicion, search.final, states, settings)
    if len(effects) == 1 or not explained:
        return dict.fromkeys(explained, effects)
    found: dict[int, tuple[Candidate, ...]] = dict.fromkeys(explained, ())
    for effect in effects:
        # an effect that is missing everywhere is none that explains this run
        fit = identify_parameters(states, without(search.final.robot, effect), settings)
        agreeing = _agreeing(explained, suspicion, fit, states, settings)
        found |= {run: (*found[run], effect) for run in explained - agreeing}
    return {run: needed for run, needed in found.items() if needed}


def _agreeing(runs: set[int], suspicion: Suspicion, fit: Fit, states: LoadStates, settings: Settings) -> set[int]:
    """Return which of these runs are like the others in a fit of all of them."""
    try:
        _, whitened = Bench.of(fit, settings.fixed, states)
    except NoBalanceError:
        return set()
    scores = whitened.scores(())
    others = np.delete(scores, [suspect.run for suspect in suspicion.suspects])
    limit = max(CURED, CURED_AGAINST_OTHERS * float(others.max(initial=0.0)))
    return {run for run in runs if scores[run] <= limit}
