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
    found = []
    for one in fit.robot.placed:
        if one.effect.name in basic or not one.effect.parameters:
            continue
        candidate = Candidate(one.effect, one.place, len(one.effect.parameters))
        scan = scan_candidates(bench.fit(without(fit.robot, candidate)), [candidate])
        if not any(judge(scan, trial).supported for trial in scan.trials):
            found.append(candidate)
    return found
