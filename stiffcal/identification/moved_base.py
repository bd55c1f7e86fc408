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

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.fit import Fit
from stiffcal.identification.row_layout import ROTATION, TRANSLATION
from stiffcal.measurements.load_states import LoadStates

# Moves whose probability by chance, of all rows, is larger are none.
MOST_P = 0.01
# Where the model leaves more than noise, what it leaves may look like a move: five standard errors after all rows, and
# what neighbouring rows share, are allowed for.
MISFIT, MOST_P_WITH_MISFIT = 1.5, 6e-7
# Rows on either side of a move: a motion of six numbers that fewer rows show, or of which one row shows more than half,
# is a mistake in these rows.
LEAST_ROWS, MOST_OF_ONE_ROW = 6, 0.5
# Columns of which others leave less than this share are sums of them, but for rounding.
SAME = 1e-9
# Draws of noise, and how many at once: at the limit of 1 % ten of a thousand exceed what was found.
DRAWS, AT_ONCE = 1000, 25
# The rows between which it happened hold the right ones with this probability.
IN_RANGE = 0.95
# Numbers of a motion.
NUMBERS = 6
# Courses of a drift: in proportion to the rows' number, or settling with time constants of these shares of all rows.
SETTLING = (1.0 / 3.0, 0.1)
# Of two explanations one is decidedly the better at odds of twenty to one.
DECIDED = float(np.log(20.0))


@dataclass(frozen=True)
class MovedBase:
    """A rigid motion of all places from one row on."""

    state: int
    """Index of the first row after it, the likeliest, among the campaign's states."""
    between: tuple[int, int]
    """Indices of two rows, among the campaign's states, between which it happened with 95 % probability."""
    one_place: bool
    """True where no other row was measured between these two."""
    shift: Floats
    """(3,) m, of the places at their centre, base axes."""
    turn: Floats
    """(3,) rad, base axes."""
    standard_errors: float
    """The probability of a larger one by chance, as standard errors of a normal distribution, all rows allowed for."""
    or_drift: bool
    """True where a drift over the rows explains the residual as well."""
    leave_out: Booleans
    """(n,) True for the campaign's absolute states on the shorter side."""


def moved_base(fit: Fit, states: LoadStates) -> MovedBase | None:
    """Return the move of the base that the rows of absolute runs show; None where they show none.

    Parameters
    ----------
    fit : of the present model to these states.
    states : the campaign's states, runs in the order of the manifest.
    """
    data = fit.data
    rows = np.flatnonzero(data.absolute & data.measured_mask.any(axis=0))
    if fit.whitening is None or len(rows) < 2 * LEAST_ROWS or fit.dof < NUMBERS + 1:
        return None
    rows = rows[_as_measured(states, data.index[rows])]
    steps, left = _steps(fit, states, rows)
    gains, solution = steps.gains(left[:, :, None])
    gain = gains[:, 0]
    k = int(np.argmax(gain))
    unit = max(1.0, (float(np.sum(left**2)) - float(gain[k])) / max(fit.dof - NUMBERS, 1))
    misfit = unit >= MISFIT
    motion = solution[k, :, 0]
    still = (left - steps.step(k) @ motion)[:, steps.first :]
    unit = max(unit, _shared_in_rows(still, (steps.own @ motion)[:, steps.first :]))
    unit *= _shared_by_rows(still) if misfit else 1.0
    gain = gain / unit
    probability = _by_chance(steps, float(gain[k]), MOST_P_WITH_MISFIT if misfit else MOST_P)
    if probability is None or steps.largest_share(left, k, motion) > MOST_OF_ONE_ROW:
        return None
    spread = max(float(gain[k]) / NUMBERS - 1.0, 0.0)
    of_rows = _evidence(gain[steps.looked_at], NUMBERS, spread)
    squares, numbers = steps.drifts(left)
    of_drifts = _evidence(squares / unit, numbers, spread)
    # log odds of a drift over a move; all rows, and all courses of a drift, count alike
    drift = _log_mean(of_drifts) - _log_mean(of_rows)
    if drift > DECIDED:
        return None
    from scipy.special import ndtri

    low, high = (steps.looked_at[end] for end in _range(of_rows))
    index = np.append(np.full(steps.first, -1), data.index[rows])
    before, after = index[steps.first : k], index[k:]
    leave_out = np.zeros(len(states), dtype=np.bool_)
    leave_out[after if len(after) <= len(before) else before] = True
    return MovedBase(
        state=int(index[k]),
        between=(int(index[low - 1]), int(index[high])),
        one_place=low == high,
        shift=motion[:3],
        turn=motion[3:],
        standard_errors=float(-ndtri(max(probability, 1e-300) / 2.0)),
        or_drift=drift > -DECIDED,
        leave_out=leave_out,
    )


def _as_measured(states: LoadStates, index: Integers) -> Integers:
    """Return the order in which rows were measured: run after run as in the manifest, by time within each.

    The runs' clocks may each start at zero, so that times of two runs are not compared.
    """
    names = [run.of or run.name for run in states.runs]
    run = np.array([names.index(name) for name in names])[states.run[index]]
    time = states.time[index]
    return np.asarray(np.lexsort((time, run)) if np.isfinite(time).all() else np.argsort(run, kind="stable"))


def _steps(fit: Fit, states: LoadStates, rows: Integers) -> tuple[_Steps, Floats]:
    """Return what steps between rows make, and the whitened residual (m, N), readings of other runs first."""
    data, about = fit.data, fit.linearised()
    model = about.derivative
    stack = np.concatenate([model, _rigid_motions(states, fit), fit.residual[None]])
    # load runs show nothing of the tracker's place, and keep the model's parameters where they are
    others = np.setdiff1d(np.arange(data.n_states), rows)
    white = about.space.rows(stack).reshape(stack.shape)[:, :, np.append(others, rows)]
    basis = _basis(white[: len(model)].reshape(len(model), -1).T).reshape(*white.shape[1:], -1)
    return _Steps.of(np.moveaxis(white[len(model) : -1], 0, -1), basis, len(others)), white[-1]


def _rigid_motions(states: LoadStates, fit: Fit) -> Floats:
    """Return (6, m, n) what a shift and a turn about the places' centre make in the rows: m per m and per rad."""
    data = fit.data
    position = np.moveaxis(states.position[data.index], 0, -1)
    centre = np.nanmean(position[:, :, data.absolute], axis=(0, 2))
    result = np.zeros((6, len(data.measured), data.n_states))
    for row, (kind, body, component) in enumerate(zip(data.kind, data.body, data.component, strict=True)):
        axis = int(component) % 3
        if kind == TRANSLATION:
            lever = np.nan_to_num(position[body] - centre[:, None])
            result[axis, row] = 1.0
            result[3 + (axis + 1) % 3, row] = lever[(axis + 2) % 3]
            result[3 + (axis + 2) % 3, row] = -lever[(axis + 1) % 3]
        elif kind == ROTATION:
            result[3 + axis, row] = 1.0
    return np.where(data.absolute, result, 0.0)


def _basis(columns: Floats) -> Floats:
    """Return an orthonormal basis (rows, r) of columns (rows, p)."""
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns[:, size > 0.0] / size[size > 0.0], full_matrices=False)
    return np.asarray(left[:, values > SAME * values.max(initial=1.0)])


@dataclass(frozen=True)
class _Steps:
    """What a rigid motion from each of N rows on makes in the whitened readings that the model's parameters do not."""

    own: Floats
    """(m, N, 6) the motion of each row."""
    basis: Floats
    """(m, N, r) orthonormal, of the model."""
    shared: Floats
    """(N, 6, r) what of the motion from a row on the model makes."""
    inverse: Floats
    """(N, 6, 6) covariance of the motion from a row on; zero for rows that are not looked at."""
    first: int
    """The first of the N rows that is of an absolute run."""
    looked_at: Integers
    """Rows with enough others on either side."""

    @classmethod
    def of(cls, own: Floats, basis: Floats, first: int) -> _Steps:
        """Sum up from each row on."""
        shared = _from_here(np.einsum("mna,mnr->nar", own, basis))
        square = _from_here(np.einsum("mna,mnb->nab", own, own)) - shared @ np.swapaxes(shared, 1, 2)
        looked_at = np.arange(first + LEAST_ROWS, own.shape[1] - LEAST_ROWS + 1)
        inverse = np.zeros_like(square)
        inverse[looked_at] = np.linalg.pinv(square[looked_at], rcond=1e-9, hermitian=True)
        return cls(own, basis, shared, inverse, first, looked_at)

    def gains(self, left: Floats) -> tuple[Floats, Floats]:
        """Return (N, d) the squares that a motion from each row on takes, and (N, 6, d) that motion.

        Parameters
        ----------
        left : (m, N, d) d whitened residuals.
        """
        model = np.tensordot(self.basis, left, axes=([0, 1], [0, 1]))
        target = _from_here(np.einsum("mna,mnd->nad", self.own, left)) - self.shared @ model
        solution = self.inverse @ target
        return np.sum(target * solution, axis=1), solution

    def step(self, k: int) -> Floats:
        """Return (m, N, 6) what motions from row k on make that the model does not."""
        step = np.where(np.arange(self.own.shape[1])[:, None] >= k, self.own, 0.0)
        return np.asarray(step - self.basis @ self.shared[k].T)

    def largest_share(self, left: Floats, k: int, motion: Floats) -> float:
        """Return the share of one row in what a motion from row k on takes, of the rows on the shorter side.

        Parameters
        ----------
        left : (m, N) a whitened residual. motion : (6,) of the rows from k on.
        """
        of_rows = np.sum((self.own @ motion) * left, axis=0)
        side = of_rows[k:] if len(of_rows) - k <= k - self.first else -of_rows[self.first : k]
        total = float(side.sum())
        return float(side.max()) / total if total > 0.0 else 1.0

    def drifts(self, left: Floats) -> tuple[Floats, Integers]:
        """Return the squares that drifts of several courses over the rows take, and by how many numbers.

        Parameters
        ----------
        left : (m, N) a whitened residual.
        """
        gains, numbers = [], []
        along = np.zeros(self.own.shape[1])
        along[self.first :] = np.linspace(0.0, 1.0, len(along) - self.first)
        for courses in ([along], *([1.0 - np.exp(-along / share)] for share in SETTLING), [along, along**2]):
            drift = np.concatenate([self.own * course[:, None] for course in courses], axis=2)
            columns, model = drift.reshape(-1, drift.shape[2]), self.basis.reshape(-1, self.basis.shape[2])
            unit = _basis(columns - model @ (model.T @ columns))
            gains.append(float(np.sum((left.ravel() @ unit) ** 2)))
            numbers.append(unit.shape[1])
        return np.array(gains), np.array(numbers)


def _from_here(values: Floats) -> Floats:
    """Return sums over all rows from each on, along the first axis."""
    return np.asarray(np.flip(np.cumsum(np.flip(values, axis=0), axis=0), axis=0))


def _log_mean(logs: Floats) -> float:
    """Return the logarithm of the mean of what these are the logarithms of."""
    return float(np.logaddexp.reduce(logs) - np.log(len(logs)))


def _by_chance(steps: _Steps, gain: float, most: float) -> float | None:
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
