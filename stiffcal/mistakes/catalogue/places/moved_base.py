"""Whether the base, or the tracker, was moved between two rows of absolute places.

From a row on, all places are off by one rigid motion: three shifts and three turns in base axes. For every row the
squares that such a motion takes from the residual, next to all of the model's parameters, follow from sums over the
rows. The largest of N has at most N times the probability of χ² with six degrees of freedom (Bonferroni). Steps at
neighbouring rows are much alike, so that this is too large; where it decides, rows of independent normal noise are
drawn until the answer is clear (sequential Monte Carlo test, Besag and Clifford 1991).

Whether there was a move is known better than between which rows, and a drift over the rows, which steps by a little
everywhere, may explain the same. With a normal prior of any such motion whose covariance is g times that of its
estimate (Zellner 1986), g from the largest gain, an explanation by q numbers that takes the squares G has the evidence
exp(½ G g / (1 + g)) (1 + g)^(−q/2): it distinguishes rows from each other, and a move from drifts.

Where the model leaves more than noise, what it leaves is an error of the model. The targets of a row share it, and a
motion of all of them scatters more widely than their readings do: by what is left of the rows along that motion. Rows
in like poses share it too. Rows that follow each other are then no independent readings, and sums over them scatter
more widely: by 1 + 2 Σ ρ, with the correlations ρ of what is left, weighed down linearly over the distance in rows
(Newey and West 1987), and by (1 + ρ) / (1 − ρ), ρ of neighbouring rows, at least.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mistakes.places.mistake import LeftOfPlaces, MovedRows, PlacesMistake
from stiffcal.mistakes.places.steps import LEAST_ROWS, Steps
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.wording import angle, length, significant

# Moves whose probability by chance, of all rows, is larger are none.
MOST_P = 0.01
# Where the model leaves more than noise, what it leaves may look like a move: five standard errors after all rows, and
# what neighbouring rows share, are allowed for.
MISFIT, MOST_P_WITH_MISFIT = 1.5, 6e-7
# A motion of which one row shows more than half is a mistake in this row.
MOST_OF_ONE_ROW = 0.5
# Draws of noise, and how many at once: at the limit of 1 % ten of a thousand exceed what was found.
DRAWS, AT_ONCE = 1000, 25
# The rows between which it happened hold the right ones with this probability.
IN_RANGE = 0.95
# Numbers of a motion.
NUMBERS = 6
# Of two explanations one is decidedly the better at odds of twenty to one.
DECIDED = float(np.log(20.0))


class MovedBase(PlacesMistake):
    """The base, or the tracker, was moved between two rows."""

    name = "moved-base"
    kind = SuspectKind.MOVED

    def ways(self, left: LeftOfPlaces) -> Iterator[MovedRows]:
        """Yield the move that the rows show: its rows, and a drift that may be it as well."""
        n_rows = len(left.index)
        if n_rows < 2 * LEAST_ROWS or left.dof < NUMBERS + 1:
            return
        steps, white = Steps.of(left), left.residual
        gains, solution = steps.gains(white[:, :, None])
        gain = gains[:, 0]
        k = int(np.argmax(gain))
        unit = max(1.0, (float(np.sum(white**2)) - float(gain[k])) / max(left.dof - NUMBERS, 1))
        misfit = unit >= MISFIT
        motion = solution[k, :, 0]
        still = (white - steps.step(k) @ motion)[:, steps.first :]
        unit = max(unit, _shared_in_rows(still, (steps.own @ motion)[:, steps.first :]))
        unit *= _shared_by_rows(still) if misfit else 1.0
        gain = gain / unit
        probability = _by_chance(steps, float(gain[k]), MOST_P_WITH_MISFIT if misfit else MOST_P)
        if probability is None or steps.largest_share(white, k, motion) > MOST_OF_ONE_ROW:
            return
        spread = max(float(gain[k]) / NUMBERS - 1.0, 0.0)
        of_rows = _evidence(gain[steps.looked_at], NUMBERS, spread)
        squares, numbers = steps.drifts(white)
        of_drifts = _evidence(squares / unit, numbers, spread)
        # log odds of a drift over a move; all rows, and all courses of a drift, count alike
        drift = _log_mean(of_drifts) - _log_mean(of_rows)
        if drift > DECIDED:
            return
        from scipy.special import ndtri

        low, high = (steps.looked_at[end] for end in _range(of_rows))
        index = np.append(np.full(steps.first, -1), left.index)
        before, after = index[steps.first : k], index[k:]
        leave_out = np.zeros(left.n_states, dtype=np.bool_)
        leave_out[after if len(after) <= len(before) else before] = True
        yield MovedRows(
            state=int(index[k]),
            between=(int(index[low - 1]), int(index[high])),
            one_place=low == high,
            shift=motion[:3],
            turn=motion[3:],
            standard_errors=float(-ndtri(max(probability, 1e-300) / 2.0)),
            or_drift=drift > -DECIDED,
            leave_out=leave_out,
        )

    def words(self, moved: MovedRows, rows: Sequence[str]) -> tuple[str, str]:
        """Return how far all places are displaced from which row on, and what to do."""
        first, last, likeliest = rows
        size, turn = (float(np.linalg.norm(vector)) for vector in (moved.shift, moved.turn))
        most_likely = "" if moved.one_place else f" (most likely before row {likeliest})"
        drift, cure = (
            (", or drifted over the rows", "add the drift to the model where time is logged, or fit")
            if moved.or_drift
            else ("", "fit")
        )
        motion = f"{length(size)} and {angle(turn, digits=2)}"
        displaced = (
            f"the rows' positions are displaced more and more, or at once by {motion} from row {likeliest} on"
            if moved.or_drift
            else f"from row {likeliest} on all positions are displaced: {motion}"
        )
        likely = (
            f"the base or the tracker moved between rows {first} and {last}{most_likely}{drift}: {cure} only the rows "
            "on one side of it; exclude the other rows or repeat them"
        )
        return f"{displaced}, {significant(moved.standard_errors, 2)} standard errors", likely

    def rows_in_words(self, count: int) -> str:
        """Return the rows on one side of the move."""
        return f"{count} rows before or after a move of the base"


def _log_mean(logs: Floats) -> float:
    """Return the logarithm of the mean of what these are the logarithms of."""
    return float(np.logaddexp.reduce(logs) - np.log(len(logs)))


def _by_chance(steps: Steps, gain: float, most: float) -> float | None:
    """Return the probability of a larger gain by chance, of all rows; None where it exceeds ``most``."""
    from scipy.special import chdtrc

    of_one = float(chdtrc(NUMBERS, gain))
    bound = len(steps.looked_at) * of_one
    if bound <= most:
        return bound
    # fewer draws than one in `most` cannot show it
    if of_one > most or most * DRAWS < 1.0:
        return None
    rng, larger = np.random.default_rng(0), 0
    for _ in range(DRAWS // AT_ONCE):
        noise = rng.standard_normal((*steps.own.shape[:2], AT_ONCE))
        larger += int(np.count_nonzero(steps.gains(noise)[0].max(axis=0) >= gain))
        if larger + 1 > most * (DRAWS + 1):
            return None
    return (larger + 1) / (DRAWS + 1)


def _evidence(gain: Floats, numbers: Integers | int, spread: float) -> Floats:
    """Return the logarithm of the evidence of explanations, but for what all have in common.

    Parameters
    ----------
    gain : the squares that each takes. numbers : how many each has.
    spread : covariance of the prior over that of the estimate.
    """
    return np.asarray(0.5 * gain * (spread / (1.0 + spread)) - 0.5 * numbers * np.log1p(spread))


def _range(evidence: Floats) -> tuple[int, int]:
    """Return the first and the last of the likeliest rows, which together hold the right one with 95 % probability."""
    weight = np.exp(evidence - evidence.max())
    order = np.argsort(-weight, kind="stable")
    enough = int(np.searchsorted(np.cumsum(weight[order]), IN_RANGE * weight.sum())) + 1
    return int(order[:enough].min()), int(order[:enough].max())


def _shared_in_rows(left: Floats, motion: Floats) -> float:
    """Return the variance of a row's sum along a motion, over that of independent readings with unit variance.

    Parameters
    ----------
    left : (m, N) the whitened residual, no move in it. motion : (m, N) what the motion makes of each row.
    """
    return float(np.sum(np.sum(motion * left, axis=0) ** 2) / np.sum(motion**2))


def _shared_by_rows(left: Floats) -> float:
    """Return by what factor sums over rows scatter more than those of independent rows, 1 at least.

    Parameters
    ----------
    left : (m, N) the whitened residual, rows in the order in which they were measured; no move in it.
    """
    most = int(np.sqrt(left.shape[1]))
    products = np.array([np.sum(left[:, lag:] * left[:, : left.shape[1] - lag]) for lag in range(most + 1)])
    weight = 1.0 - np.arange(1, most + 1) / (most + 1.0)
    alike = products / products[0]
    # of errors that change slowly the sum over few lags is too small; those of a first-order process go on like this
    return max(1.0, 1.0 + 2.0 * float(weight @ alike[1:]), float((1.0 + alike[1]) / (1.0 - alike[1])))
