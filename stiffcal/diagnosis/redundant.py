"""Effects that the present model holds and does not need."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.judge import judge
from stiffcal.diagnosis.scan import scan_candidates
from stiffcal.diagnosis.search import SearchContext, without
from stiffcal.identification.fit import Fit


def redundant_effects(bench: SearchContext, fit: Fit, basic: Sequence[str]) -> list[Candidate]:
    """Return effects without which the error in unseen poses is no worse.

    Parameters
    ----------
    bench : states, catalogue and settings.
    fit : of the present model.
    basic : names of effects that every model holds and that are never called superfluous.
    """
    candidates = []
    for placed_effect in fit.robot.placed:
        if placed_effect.effect.name in basic or not placed_effect.effect.parameters:
            continue
        candidate = Candidate(placed_effect.effect, placed_effect.place, len(placed_effect.effect.parameters))
        scan = scan_candidates(bench.fit(without(fit.robot, candidate)), [candidate])
        if not any(judge(scan, trial).supported for trial in scan.trials):
            candidates.append(candidate)
    return candidates
