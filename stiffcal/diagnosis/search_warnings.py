"""What limits the answer of a search: unknown or overstated noise, few poses, a wrong geometry, errors that last."""

from __future__ import annotations

from stiffcal.diagnosis.search_results import Search
from stiffcal.diagnosis.thresholds import REPORTED_LINGERING
from stiffcal.diagnosis.words import candidate_in_words, places_in_words
from stiffcal.identification.document import noise_not_known, overstated_noise_in_words, wrong_geometry_in_words


def search_warnings(search: Search) -> list[str]:
    """Return the warnings on a search, as sentences."""
    texts = []
    if search.before is None and (search.tried or search.unexplained):
        texts.append(noise_not_known("the share of noise in the error is unknown"))
    elif search.before is None:
        texts.append(noise_not_known("whether the model is good enough cannot be judged"))
    if len(search.first.folds) < 6:
        texts.append(f"only {len(search.first.folds)} poses: the error in held-out poses is poorly determined")
    if search.without_balance:
        texts.append(
            "without one of the effects that fit best together the robot has no equilibrium: whether each is needed "
            "cannot be judged, and none of them is named; measure with smaller loads, or add one of them by hand"
        )
    texts += _refused_by_places(search)
    if search.wrong_geometry is not None:
        texts.append(wrong_geometry_in_words(search.wrong_geometry.misfit, search.first.fit.robot))
    now, noise = search.after, search.first.fit.noise
    if now is not None and noise is not None:
        texts += overstated_noise_in_words(noise, now.statistic, now.dof[0])
    if now is not None and now.lag_one_correlation > REPORTED_LINGERING and not now.drifts and not search.unexplained:
        texts.append(
            f"successive readings have correlated errors (correlation {now.lag_one_correlation:.2g}): "
            "slowly varying noise (air, temperature, a filter), so the uncertainties are larger than stated; wait "
            "longer between readings"
        )
    if now is not None and not now.adequate and not search.unexplained:
        texts.append(
            f"the remaining error is {now.ratio:.2g} times the noise that the manifest states, and depends on no "
            "variable: check sigma in campaign.toml, or repeat loads to measure the noise"
        )
    return texts


def _refused_by_places(search: Search) -> list[str]:
    """Return why a set-up error that explains the displacements best is not named: absolute places do not show it."""
    leader = next(iter(search.first.trials), None)
    if leader is None or leader.places is None or not leader.places.contradicted:
        return []
    if float(leader.score.heldout.sum()) >= float(search.first.base.heldout.sum()):
        return []
    name = candidate_in_words(leader.candidate)
    reason = f"absolute positions contradict it, {places_in_words(leader.places)}"
    return [f"{name} fits the displacements best but is not named: {reason}"]
