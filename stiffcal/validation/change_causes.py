"""What a change of all parameters together can come from: a worn joint, or a change of the set-up.

Each cause would show in its own way. A worn joint turns the parameters of that joint alone. A change of the set-up that
the model does not hold (another target, a turned force sensor, other gains) is taken up by all parameters at once, in
the proportions that least squares gives them, and mostly leaves residuals that a worn joint does not leave. Where the
residuals have grown, a change of the set-up has to explain them as well, and to do so better than any law of a joint or
link that the model lacks: a bearing that tilts changes the parameters much as a turned force sensor does.

The causes are compared by their marginal likelihood: the change of the parameters is normal about zero, with the
variance of the campaigns' means and that of the cause's unknown size, which takes three scales with equal probability,
as what is usual and what is much more both happen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.validation.trend_result import Cause, ChangeCause, PossibleCause

SCALES = (1.0, 3.0, 10.0)
"""Sizes of a cause over its usual size."""
USUAL_CHANGE = 0.05
"""Share of a joint's parameter that is usual for a change; 0.15 and 0.5 count as well."""
FURTHER_JOINT = 0.1
"""Probability of a further joint that changes between the same two campaigns."""
LEAST_P = 1e-3
"""An explanation from which the change deviates with less than this probability is none."""
STRONG = 20.0
"""Odds of the first cause to the next from which on it is named alone; Kass and Raftery (1995), Bayes factors, J. Am.
Stat. Assoc. 90: strong evidence."""
GROWN = 1.2
"""Reduced χ² since the change over that before from which on the residuals have grown."""
SHOWN = 0.01
"""Causes below this probability are not listed."""


@dataclass(frozen=True)
class Hypothesis:
    """One cause, as what it would do to the p parameters."""

    directions: Floats
    """(q, p) change of the parameters per usual size of each of its q unknown sizes."""
    joints: tuple[int, ...] = ()
    """From 1; empty of a set-up."""
    effect: str = ""
    """Of a set-up, its name."""

    @property
    def log_prior(self) -> float:
        """Joints seldom wear in the same month."""
        return (len(self.joints) - 1) * float(np.log(FURTHER_JOINT)) if len(self.joints) > 1 else 0.0


def cause_of(
    change: Floats, covariance: Floats, hypotheses: Sequence[Hypothesis], since: int, misfit_grew: bool
) -> ChangeCause:
    """Return what a change can come from.

    Parameters
    ----------
    change : (p,) of the amplitudes, mean after minus mean before.
    covariance : (p, p) of it on an unchanged robot, positive definite.
    hypotheses : what is compared; at least one.
    since : number of the first campaign after the change.
    misfit_grew : whether the residuals have grown with it: then no change of the joints alone is named.
    """
    from scipy.special import chdtrc

    weights, p_values = np.zeros(len(hypotheses)), np.zeros(len(hypotheses))
    for number, hypothesis in enumerate(hypotheses):
        logs = []
        for scale in SCALES:
            total = covariance + scale**2 * hypothesis.directions.T @ hypothesis.directions
            factor = np.linalg.cholesky(total)
            distance = float(np.sum(np.linalg.solve(factor, change) ** 2))
            logs.append(-0.5 * distance - float(np.sum(np.log(np.diag(factor)))))
            p_values[number] = max(p_values[number], float(chdtrc(len(change), distance)))
        weights[number] = hypothesis.log_prior + float(np.logaddexp.reduce(logs))
    weights = np.exp(weights - np.logaddexp.reduce(weights))
    order = np.argsort(-weights)
    causes = [
        PossibleCause(
            kind="joint" if hypotheses[k].joints else "set-up",
            effect=hypotheses[k].effect,
            joints=list(hypotheses[k].joints),
            p_value=float(p_values[k]),
            probability=float(weights[k]),
            softer=_softer(hypotheses[k], change, covariance) if hypotheses[k].joints else None,
        )
        for k in order
    ]
    kept = [causes[0], *(cause for cause in causes[1:] if cause.probability >= SHOWN)]
    verdict = _verdict(causes)
    if misfit_grew and verdict in ("wear", "stiffened"):
        verdict = "unexplained"
    return ChangeCause(verdict=verdict, since=since, misfit_grew=misfit_grew, causes=kept, explains_residuals=[])


def held_to_residuals(cause: ChangeCause, set_up: Mapping[str, float], elsewhere: Mapping[str, float]) -> ChangeCause:
    """Return what a change can come from where the residuals have grown with it.

    Parameters
    ----------
    cause : by the parameters alone.
    set_up : χ² that each effect of the set-up leaves, by name; of those alone with which the residuals are again as
        they were before the change.
    elsewhere : the same of effects of joints and links that the model does not hold, by effect and place.

    Returns
    -------
    ChangeCause
        Of one that was not unexplained: "set-up" where a change of the set-up explains parameters and residuals, with
        odds of `STRONG` to one against each effect elsewhere (equal prior odds: χ² differ by 2 ln `STRONG`);
        "undecided" where another effect does as well; else "unexplained". Causes that explain both come first.
    """
    both = [one for one in cause.causes if one.effect in set_up and one.p_value >= LEAST_P]
    least = min([set_up[one.effect] for one in both] or elsewhere.values(), default=np.inf)
    limit = least + 2.0 * float(np.log(STRONG))
    alike = sorted((name for name, left in elsewhere.items() if left <= limit), key=lambda name: elsewhere[name])
    verdict: Cause = "unexplained"
    if both and cause.verdict != "unexplained":
        verdict = "undecided" if alike else "set-up"
    causes = [*both, *(one for one in cause.causes if one not in both)]
    return replace(cause, verdict=verdict, causes=causes, explains_residuals=alike)


def grown_since(reduced_chi2: Sequence[float | None], since: int) -> int | None:
    """Return the number of the first campaign with grown residuals; None where they have not grown with a change.

    Parameters
    ----------
    reduced_chi2 : one a campaign; None where the noise is not known: then no verdict is possible.
    since : number of the first campaign after the change, as the chart has it; scatter moves it by a campaign.
    """
    near = (since, since - 1, since + 1)
    return next((k for k in near if 0 < k < len(reduced_chi2) and grew(reduced_chi2, k)), None)


def grew(reduced_chi2: Sequence[float | None], since: int) -> bool:
    """Return whether residuals over noise are larger in every campaign since a change, by a fifth in the mean.

    Parameters
    ----------
    reduced_chi2 : one a campaign; None where the noise is not known: then no verdict is possible.
    since : number of the first campaign after the change.
    """
    known = [value for value in reduced_chi2 if value is not None]
    if len(known) < len(reduced_chi2):
        return False
    before, after = known[:since], known[since:]
    return min(after) > max(before) and float(np.mean(after)) > GROWN * float(np.mean(before))


def _verdict(causes: Sequence[PossibleCause]) -> Cause:
    first = causes[0]
    if first.p_value < LEAST_P:
        return "unexplained"
    # two causes of the same sort, such as a joint alone and with another, leave the sort decided
    others = sum(cause.probability for cause in causes if _sort(cause) != _sort(first))
    own = sum(cause.probability for cause in causes if _sort(cause) == _sort(first))
    return _sort(first) if own > STRONG * others else "undecided"


def _sort(cause: PossibleCause) -> Cause:
    if cause.kind == "set-up":
        return "set-up"
    return "wear" if cause.softer else "stiffened"


def _softer(hypothesis: Hypothesis, change: Floats, covariance: Floats) -> bool:
    """Return whether the joints' amplitudes grow: the sizes' sum, each over its uncertainty."""
    directions = hypothesis.directions
    inverse = np.linalg.inv(covariance)
    precision = directions @ inverse @ directions.T + np.eye(len(directions)) / SCALES[-1] ** 2
    sizes = np.linalg.solve(precision, directions @ inverse @ change)
    return bool(np.sum(sizes * np.sqrt(np.diag(precision))) > 0.0)
