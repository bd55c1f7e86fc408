"""Several missing effects, found one after another, superfluous ones dropped again.

Forward: the best supported candidate is added and everything refitted on the balanced robot, until nothing is
supported. Then every effect that was added is taken out again and all candidates are tried in its place with the
others: one that is no longer needed is dropped, one that another beats is exchanged. What cannot be distinguished from
the best in that last look is its look-alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import confidence
from stiffcal.diagnosis.decision import decide
from stiffcal.diagnosis.deletions import rivals_without_a_pose, too_many_alike
from stiffcal.diagnosis.explained import explained_share
from stiffcal.diagnosis.judge import LackOfFit, judge, judge_choice, lack_of_fit, possible_values
from stiffcal.diagnosis.naming import look_alikes, near_best, ties_with_named
from stiffcal.diagnosis.pairs import best_pair
from stiffcal.diagnosis.scan import Scan, Trial, score_together
from stiffcal.diagnosis.search_context import NoBalanceWithError, SearchContext, without
from stiffcal.diagnosis.search_results import F, MissingEffect, S, SearchOf
from stiffcal.diagnosis.sufficient import sufficient_alone
from stiffcal.diagnosis.thresholds import (
    EVIDENCE_TIE,
    LEAST_FALL,
    MOST_EFFECTS,
    MOST_FOR_TWO,
)
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.no_balance import NoBalanceError


def search_in(bench: SearchContext[S, F], robot: CompliantRobot, progress: Progress = no_progress) -> SearchOf[S, F]:
    """Find which effects a model lacks, in the data of a context.

    Parameters
    ----------
    bench : data, catalogue and settings.
    robot : the present model, with or without values.
    progress : receives a description of each step.

    Raises
    ------
    InputError : the data hold no more readings than the model has values.
    """
    # Each time one candidate fewer takes part.
    while True:
        try:
            return _search(bench, robot, progress)
        except NoBalanceWithError as error:
            bench.exclude(error.name)


def _search(bench: SearchContext[S, F], robot: CompliantRobot, progress: Progress) -> SearchOf[S, F]:
    """Add what is supported, reconsider each effect, simplify, and conclude."""
    progress("testing every effect at every place", 0.05)
    first = scan = bench.look(robot)
    _check_something_is_left(first)
    chosen: list[Candidate] = []
    while len(chosen) < MOST_EFFECTS:
        best = _promising(scan)
        if best is None or best.candidate.effect.general:
            # A general law mimics much: two simple effects that do as well come before it.
            together = _pair(bench, scan, progress, best) if len(chosen) + 2 <= MOST_EFFECTS else None
            if together is not None:
                more, scan = together
                chosen.extend(more)
                continue
            if best is None:
                break
        progress(f"adding {best.candidate.name}", 0.2 + 0.1 * len(chosen))
        chosen.append(best.candidate)
        scan = bench.look_with(scan.fit.robot, best)
    try:
        scan, tried = _judged(bench, first, scan, chosen, progress)
    except NoBalanceError:
        # Laws that have no equilibrium without one of them explain nothing: whether it is needed cannot be judged.
        return replace(_conclude(bench, first, first, ()), without_balance=True)
    return _conclude(bench, first, scan, tried)


def _judged(
    bench: SearchContext[S, F], first: S, scan: S, chosen: list[Candidate], progress: Progress
) -> tuple[S, tuple[MissingEffect, ...]]:
    """Return the look at the model with what is needed of the effects that were added, and these as judged.

    Raises
    ------
    NoBalanceError : without one of the effects the robot has no equilibrium.
    """
    scan, tried = _reconsider(bench, first, scan, chosen, progress)
    # Of a set that is no explanation there is nothing to be made simpler.
    now = lack_of_fit(scan.fit, scan)
    adequate = now is None or now.adequate
    simpler = (
        one_for_two(bench, first, scan, [missing_effect.candidate for missing_effect in tried], progress)
        if adequate
        else None
    )
    if simpler is not None:
        scan, tried = _reconsider(bench, first, *simpler, progress)
    return scan, tried


def _check_something_is_left(scan: Scan) -> None:
    """Raise an `InputError` where the model's own values use up all readings: no residual could show an effect."""
    if scan.dof <= scan.n_columns:
        reason = f"{max(scan.dof, 0)} readings for {scan.n_columns} parameters of the model"
        mend = "measure more poses or loads, or remove effects from model.toml: there are no degrees of freedom left"
        raise InputError.at(FaultCode.DATA_MISSING, "campaign.toml", "runs", reason, mend)


def _promising(scan: Scan) -> Trial | None:
    """Return the leader of a scan where it is supported but for the choice repeated in every fold.

    Where two effects are missing, now the one, now the other is chosen without some of the poses, and the error of
    either alone hardly falls in the others: that is evidence against neither. Each has to stand when all the others are
    in.
    """
    near = near_best(scan)
    return near[0] if near and judge(scan, near[0]).supported else None


def _supported(scan: Scan) -> Trial | None:
    """Return the leader of a scan where it is supported."""
    near = near_best(scan)
    if not near or not judge_choice(scan, near[0]).supported:
        return None
    return near[0]


def _pair(
    bench: SearchContext[S, F], scan: S, progress: Progress, general: Trial | None
) -> tuple[list[Candidate], S] | None:
    """Return two effects that explain together what none explains alone, and the scan with both; None without.

    They must explain all of it, or as much as the general law that would else be named: of so many pairs some go a
    long way with what is none of them.
    """
    now = lack_of_fit(scan.fit, scan)
    if general is None and (now is None or now.adequate):
        return None
    progress("testing pairs", 0.5)
    pair = best_pair(scan)
    if pair is None:
        return None
    look = bench.look_with(scan.fit.robot, *pair)
    then = lack_of_fit(look.fit, look)
    as_good = general is not None and _error(look) <= _error(scan, general) + LEAST_FALL
    if not as_good and (then is None or not then.adequate):
        return None
    return [trial.candidate for trial in pair], look


def _supported_effect(scan: Scan, candidate: Candidate) -> MissingEffect | None:
    """Return the candidate, or the one that beats it in the scan; None where neither is supported."""
    near = near_best(scan)
    if not near or not judge_choice(scan, near[0]).supported:
        return None
    # The one that is in the model already stays where the evidence ties: the search would else go round in a circle.
    same = [trial for trial in near if trial.candidate.name == candidate.name and judge(scan, trial).supported]
    chosen = same[0] if same and ties_with_named(scan, near, same[0]) else near[0]
    others, cosines = look_alikes(scan, near, chosen)
    rivals = rivals_without_a_pose(scan, near, chosen) or too_many_alike(scan, near, chosen)
    return MissingEffect(chosen.candidate, others, judge_choice(scan, chosen), rivals, cosines=cosines)


def _basic_effect(scan: Scan, candidate: Candidate) -> MissingEffect:
    """Return an effect on top of which all others come: it stays, whatever does as well."""
    trial = next(trial for trial in scan.trials if trial.candidate.name == candidate.name)
    return MissingEffect(candidate, (), judge_choice(scan, trial))


def _reconsider(
    bench: SearchContext[S, F], first: S, scan: S, chosen: list[Candidate], progress: Progress
) -> tuple[S, tuple[MissingEffect, ...]]:
    """Take each added effect out again and see what belongs in its place."""
    tried: dict[str, MissingEffect] = {}
    for _ in range(2):
        changed = False
        for number, candidate in enumerate(list(chosen)):
            progress(f"is {candidate.name} still needed?", 0.6 + 0.05 * number)
            look = bench.look(_reduced(first, scan.fit.robot, candidate))
            missing_effect = _supported_effect(look, candidate)
            if candidate.effect.name in bench.basic:
                missing_effect = _basic_effect(look, candidate)
            if missing_effect is not None and missing_effect.candidate.name == candidate.name:
                tried[candidate.name] = missing_effect
                continue
            changed = True
            chosen.remove(candidate)
            tried.pop(candidate.name, None)
            scan = look
            if missing_effect is not None:
                trial = next(t for t in look.trials if t.candidate.name == missing_effect.candidate.name)
                scan = bench.look_with(look.fit.robot, trial)
                chosen.insert(number, missing_effect.candidate)
                tried[missing_effect.candidate.name] = missing_effect
        if not changed:
            break
    return scan, tuple(tried[candidate.name] for candidate in chosen if candidate.name in tried)


def _reduced(first: S, robot: CompliantRobot, *candidates: Candidate) -> CompliantRobot:
    """Return a model without some effects."""
    for candidate in candidates:
        robot = without(robot, candidate, first.fit.robot)
    return robot


def one_for_two(
    bench: SearchContext[S, F], first: S, scan: S, chosen: list[Candidate], progress: Progress
) -> tuple[S, list[Candidate]] | None:
    """Return a model in which one effect does what two did, with its effects; None where none does.

    Bending of a link is much like a tilt at each of its ends: of such a pair the first is best added to the poorer
    model, and then the second makes up for it. One that errs more where the poses are drawn anew is not enough.
    """
    for pair in combinations([candidate for candidate in chosen if candidate.effect.name not in bench.basic], 2):
        progress(f"is one effect enough for {pair[0].name} and {pair[1].name}?", 0.8)
        try:
            look, left = bench.look(_reduced(first, scan.fit.robot, *pair)), MOST_FOR_TWO
        except NoBalanceError:
            continue
        names = {candidate.name for candidate in pair}
        members = [trial for trial in look.trials if trial.candidate.name in names]
        for trial in look.trials:
            # Errors about another model are no better known than this; what counts is the refit below.
            if _error(look, trial) > _error(scan) + 5.0 * LEAST_FALL:
                break
            if (
                trial.candidate.name in names
                or not possible_values(look, trial)
                or not no_less_likely(look, trial, members)
            ):
                continue
            if _error(bench.error_alone(look.fit.robot, trial)) > _error(scan) + LEAST_FALL:
                continue
            better, left = bench.look_with(look.fit.robot, trial), left - 1
            if _error(better) <= _error(scan) + LEAST_FALL and _supported(better) is None:
                return better, [*(candidate for candidate in chosen if candidate not in pair), trial.candidate]
            if left == 0:
                break
    return None


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


def _error(scan: Scan, trial: Trial | None = None) -> float:
    """Return the held-out error over the noise, of the scan's model or of that model with a candidate."""
    score = scan.base if trial is None else trial.score
    return float(np.sqrt(np.sum(score.heldout) / scan.dof))


def _conclude(bench: SearchContext[S, F], first: S, scan: S, tried: tuple[MissingEffect, ...]) -> SearchOf[S, F]:
    present, fit = bench.fit_of(first), bench.fit_of(scan)
    _, not_tried = bench.candidates(present.robot)
    # What matters most is named first: the order of finding is that of falls against a poorer model.
    tried = tuple(sorted(tried, key=lambda missing_effect: -missing_effect.judgement.fall))
    after = lack_of_fit(fit, scan)
    before = lack_of_fit(present, first)
    explained = explained_share(first, scan, before, after)
    # What is left without structure is noise, more of it than stated: it is not avoidable, and no part of the share.
    noise_understated = after is not None and not after.adequate and _mere_noise(bench, scan, after)
    partly_explained = bool(tried) and after is not None and not noise_understated and not explained.whole
    # Where no noise is known, only a structure of what is left shows that something is.
    structured = after is None and bool(bench.follows(scan))
    unexplained = structured or partly_explained or (after is not None and not after.adequate and not noise_understated)
    withheld = unexplained and explained.too_little
    supported = () if withheld else tried
    decision = decide(supported)
    could_be = sufficient_alone(first) if unexplained and not supported else ()
    return SearchOf(
        first,
        decision.named,
        tried,
        fit,
        scan,
        before,
        after,
        explained,
        unexplained,
        tuple(not_tried),
        bench.pace(),
        decision.undecided,
        decision.undecided_next,
        could_be=could_be,
    )


def _mere_noise(bench: SearchContext[S, F], scan: S, after: LackOfFit) -> bool:
    """Return whether what is left above a noise that was only stated is no structure, but more noise than stated."""
    noise = scan.fit.noise
    return noise is not None and noise.source == "manifest" and not after.drifts and not bench.follows(scan)
