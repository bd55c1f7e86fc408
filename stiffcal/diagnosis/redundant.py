"""Effects that a model of moving joints holds and does not need."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.judge import judge, reduction_between
from stiffcal.diagnosis.search_context import SearchContext, without
from stiffcal.diagnosis.search_results import F, S
from stiffcal.diagnosis.thresholds import LEAST_FALL, STANDARD_ERRORS


def redundant_effects(bench: SearchContext[S, F], fit: F, basic: Sequence[str]) -> list[Candidate]:
    """Return effects without which, taken together, the error in held-out poses is no worse.

    It is worse where it rises by more than a hundredth of the noise, or by more than two standard errors over poses.

    Of two effects that explain the same displacements one is kept: each is judged in the model without those before it.
    Several that are needed only together are kept, too: what all removals cost is held against the present model.

    Parameters
    ----------
    bench : states, catalogue and settings.
    fit : of the present model.
    basic : names of effects that every model holds and that are never called superfluous.
    """
    candidates: list[Candidate] = []
    present, robot = bench.scan(fit, []), fit.robot
    for placed_effect in fit.robot.placed:
        effect = placed_effect.effect
        # Frames to be estimated are the manifest's choice, not the model file's: no command could remove them.
        if effect.name in basic or placed_effect.place.kind == "frames" or not effect.parameters:
            continue
        # a form that holds a basic effect stands for it
        if set(effect.includes) & set(basic):
            continue
        candidate = Candidate(effect, placed_effect.place, len(effect.parameters))
        reduced = without(robot, candidate)
        scan = bench.scan(bench.fit(reduced), [candidate], fit)
        # However few the poses are by which a rise could be judged: what serves is not taken away for want of proof;
        # nor is what many poses show, however small it is.
        rise, errors = reduction_between(scan, present)
        worse = rise > LEAST_FALL or errors > STANDARD_ERRORS
        if not worse and not any(judge(scan, trial).supported for trial in scan.trials):
            candidates.append(candidate)
            robot = reduced
    return candidates
