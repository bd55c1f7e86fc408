"""One effect at several joints as one candidate, and such sets held against one effect that lies between the joints.

A law with several parameters can take up what simpler laws at the joints next to it do together: a link's three springs
are much like the tilts of the bearings at its ends. No candidate at a single joint comes near then, although two
together do as well. So a named spring law is compared with what like laws do at the joints next to it, and what cannot
be separated from it is listed (physics, section 5.4).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import confidence
from stiffcal.diagnosis.judge import alike
from stiffcal.diagnosis.naming import look_alikes
from stiffcal.diagnosis.scan import Scan, Trial, ranked_error, score_together
from stiffcal.diagnosis.search_results import MissingEffect
from stiffcal.diagnosis.thresholds import EVIDENCE_TIE
from stiffcal.identification.regressors import Regressor
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Effect, NodeLoads, ParameterRole, Place, joint_nodes, tool_node

# A law with fewer parameters is no sum of laws at two joints.
LEAST_PARAMETERS = 3


def as_one(scan: Scan, trials: Sequence[Trial]) -> Trial:
    """Return one effect at several joints as one candidate, at each joint in the shape that is best there alone.

    Parameters
    ----------
    scan : in which each was tried.
    trials : of one effect, each at one joint.
    """
    trials = sorted(trials, key=lambda trial: trial.candidate.place.joints)
    first = trials[0].candidate
    place = Place("joints", tuple(trial.candidate.place.joints[0] for trial in trials))
    regressor = Regressor(
        first.effect,
        place,
        {},
        tuple(symbol for trial in trials for symbol in trial.regressor.symbols),
        np.concatenate([trial.regressor.columns for trial in trials]),
        np.sum([trial.regressor.fixed for trial in trials], axis=0),
    )
    shapes = sum(spec.role is ParameterRole.NONLINEAR for spec in first.effect.parameters)
    return Trial(
        Candidate(first.effect, place, len(regressor.symbols) + shapes * len(trials)),
        regressor,
        score_together(scan, trials),
        sum(trial.n_variants for trial in trials),
    )


def with_sets_alike(scan: Scan, missing_effect: MissingEffect) -> MissingEffect:
    """Return a missing effect with the sets of like effects that cannot be separated from it among its alternatives.

    Among them is also one law at all joints where it errs clearly less: then the named place is one of several.

    Parameters
    ----------
    scan : of the model without the effect.
    missing_effect : as found; returned as it is where no set comes near, or where it is undecided already.
    """
    named = _trial_of(scan, missing_effect.candidate)
    if named is None or missing_effect.rivals:
        return missing_effect
    sets = _smallest([one for one in sets_next_to(scan, named) if alike(scan, one, named)])
    sets += [one for one in _everywhere(scan, named) if not alike(scan, named, one)]
    if not sets:
        return missing_effect
    known = [_trial_of(scan, candidate) for candidate in missing_effect.alternatives]
    others = [*sets, *(trial for trial in known if trial is not None)]
    share = confidence(scan, among=[named, *others])
    others.sort(key=lambda trial: (trial.candidate.effect.general, -share[trial.candidate.name]))
    alternatives, cosines = look_alikes(scan, others, named)
    return replace(missing_effect, alternatives=alternatives, cosines=cosines)


def better_set(scan: Scan, candidate: Candidate) -> tuple[Trial, ...]:
    """Return the like effects next to a named one that together err clearly less in poses left out; empty without.

    Parameters
    ----------
    scan : of the model without the candidate. candidate : what is named.
    """
    named = _trial_of(scan, candidate)
    if named is None:
        return ()
    better = [one for one in sets_next_to(scan, named) if not alike(scan, named, one)]
    if not better:
        return ()
    best = min(better, key=ranked_error)
    joints = best.candidate.place.joints
    return tuple(
        trial
        for trial in scan.trials
        if trial.candidate.effect.name == best.candidate.effect.name
        and set(trial.candidate.place.joints) <= set(joints)
    )


def no_less_likely(scan: Scan, one: Trial, members: Sequence[Trial]) -> bool:
    """Return whether one effect errs least often enough, against several together, to take their place.

    Where poses are drawn anew it must come first at least half as often as they do, as a simpler effect that is named.
    Of one that is not a candidate next to the others, because a law includes it, nothing is known: then it is.
    """
    if len(members) < 2:
        return True
    candidate = Candidate(members[0].candidate.effect, members[0].candidate.place, 0)
    several = replace(members[0], candidate=candidate, score=score_together(scan, members))
    share = confidence(scan, among=[one, several])
    return share[one.candidate.name] >= EVIDENCE_TIE * share[several.candidate.name]


def sets_next_to(scan: Scan, named: Trial) -> Iterator[Trial]:
    """Yield what spring laws at neighbouring joints do together, for a spring law with several parameters.

    Of the joints next to the nodes at which the named law acts, two or more in a row, with at most one parameter more
    than the law has. Sets of which a member does nothing are those of fewer joints.
    """
    effect, place = named.candidate.effect, named.candidate.place
    if not _is_spring(effect) or named.candidate.n_parameters < LEAST_PARAMETERS:
        return
    runs = list(_runs(_joints_next_to(effect, place, scan.fit.robot.chain)))
    for law, trials in laws_at_joints(scan).items():
        if law == effect.name or not _is_spring(next(iter(trials.values())).candidate.effect):
            continue
        for members in (
            [trials[joint] for joint in run if joint in trials] for run in runs if trials.keys() >= set(run)
        ):
            if sum(one.candidate.n_parameters for one in members) <= named.candidate.n_parameters + 1:
                together = as_one(scan, members)
                if _all_act(together, members):
                    yield together


def _everywhere(scan: Scan, named: Trial) -> list[Trial]:
    """Return the named law at all joints; of a spring law, other spring laws at all joints."""
    effect = named.candidate.effect
    spring = _is_spring(effect) and named.candidate.n_parameters >= LEAST_PARAMETERS
    laws = {
        law: trials
        for law, trials in laws_at_joints(scan).items()
        if len(trials) > 1
        and (law == effect.name or (spring and _is_spring(next(iter(trials.values())).candidate.effect)))
    }
    return [as_one(scan, list(trials.values())) for trials in laws.values()]


def laws_at_joints(scan: Scan) -> dict[str, dict[int, Trial]]:
    """Return the simple laws of single joints: their candidates by joint."""
    laws: dict[str, dict[int, Trial]] = {}
    for trial in scan.trials:
        effect, place = trial.candidate.effect, trial.candidate.place
        if place.kind == "joints" and not effect.general and trial.regressor.symbols:
            laws.setdefault(effect.name, {})[place.joints[0]] = trial
    return laws


def _trial_of(scan: Scan, candidate: Candidate) -> Trial | None:
    return next((trial for trial in scan.trials if trial.candidate.name == candidate.name), None)


def _smallest(sets: Sequence[Trial]) -> list[Trial]:
    """Return the sets that hold no other of the same law."""
    return [
        one
        for one in sets
        if not any(
            other.candidate.effect.name == one.candidate.effect.name
            and set(other.candidate.place.joints) < set(one.candidate.place.joints)
            for other in sets
        )
    ]


def _is_spring(effect: Effect) -> bool:
    """Return whether a law's displacement is in proportion to what its nodes carry."""
    if any(spec.role is ParameterRole.NONLINEAR for spec in effect.parameters):
        return False
    return any(spec.compliance or spec.inverse for spec in effect.parameters)


def _joints_next_to(effect: Effect, place: Place, chain: Chain) -> list[int]:
    """Return the joints next to where a law acts: a joint and those before and after it, or the two nearest."""
    unloaded = NodeLoads(np.zeros((tool_node(chain) + 1, 6, 1)), np.zeros((chain.n_joints, 1)))
    nodes = {term.node for term in effect.terms(place, chain, unloaded, {})}
    joints: set[int] = set()
    for node in nodes:
        distance = np.abs(joint_nodes(chain) - node)
        joints.update((1 + np.flatnonzero(distance <= np.sort(distance)[:2].max())).tolist())
    return sorted(joints)


def _runs(joints: Sequence[int]) -> Iterator[range]:
    """Yield every two or more of some joints that follow each other in the chain."""
    for first, last in combinations(joints, 2):
        if set(range(first, last + 1)) <= set(joints):
            yield range(first, last + 1)


def _all_act(together: Trial, members: Sequence[Trial]) -> bool:
    """Return whether each member of a set has a value that is not nothing."""
    ends = np.cumsum([len(trial.regressor.symbols) for trial in members])
    own = together.score.solution[len(together.score.solution) - ends[-1] :]
    return all(bool(part.any()) for part in np.split(own, ends[:-1]))
