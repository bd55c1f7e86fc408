"""Which runs separate rival models: T-optimality.

Were the first model true, the second, refitted to the same runs, would miss the readings by at least
Δ = min over its parameters of Σ |η₁ − η₂|², in units of the noise: what a test of the two goes by. The design makes the
smallest Δ of all ordered pairs as large as it can be. With d = η₁ − η₂ at the present values and the columns A of the
second model, Δ = dᵀd − dᵀA (M₀ + AᵀA)⁻¹ Aᵀd, the inverse of the variance that the coefficient of d would have next to
A: the largest variance of these coefficients is what `design` minimises, bound and exchange included.

Sources: A. C. Atkinson, V. V. Fedorov, "The design of experiments for discriminating between two rival models",
Biometrika 62, 1975, and "Optimal design: experiments for discriminating between several models", ibid.; the coefficient
of the difference: A. C. Atkinson, "Planning experiments to detect inadequate regression models", Biometrika 59, 1972.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import Observations, predicted, rests
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.noise.reading_noise import Noise, Whitening
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.planning.criterion import Criterion
from stiffcal.planning.design import VAGUE, Design, best_design, compressed
from stiffcal.planning.goals import Goal
from stiffcal.planning.information import RunKind, information_of_runs
from stiffcal.planning.repeats import Repeats


@dataclass(frozen=True)
class RivalModel:
    """A model that could be true."""

    robot: CompliantRobot
    """With values."""
    names: tuple[str, ...]
    """Full names of k of its parameters that data already fix; empty where nothing was measured."""
    information: Floats
    """(k, k) the inverse of their covariance, in the units of what the laws multiply with."""
    noise: Noise | None = None
    """Of one load state, as the fit with this model finds it; None: as stated for all. A model without the effect takes
    part of it for noise of the wrench.
    """

    @classmethod
    def of_covariance(
        cls, robot: CompliantRobot, covariance: dict[str, dict[str, float]], noise: Noise | None = None
    ) -> RivalModel:
        """Return a model with the noise and the covariance of its fit; that, by full names, may be empty."""
        names = tuple(covariance)
        matrix = np.array([[covariance[a][b] for b in names] for a in names]).reshape(len(names), len(names))
        return cls(robot, names, np.linalg.inv(matrix) if names else matrix, noise)

    @classmethod
    def of_data(
        cls, robot: CompliantRobot, data: Observations, whitening: Whitening, fixed: frozenset[str]
    ) -> RivalModel:
        """Return a model with what observations would fix of its parameters at its present values."""
        rows = LoadRows.about(robot, data, free_columns(robot, fixed), whitening)
        return cls(robot, rows.unknowns.names, rows.white[:-1] @ rows.white[:-1].T)


@dataclass(frozen=True)
class PairInformation:
    """What N runs bring on one ordered pair of models."""

    truth: int
    """Index of the model that is taken as true."""
    rival: int
    """Index of the model that is refitted."""
    factors: Floats
    """(N, r, p + 1): columns of the rival's p parameters, then the models' difference; whitened, offsets taken out."""
    known: Floats
    """(p + 1, p + 1) what data already fix of the rival's parameters."""

    def separation(self, chosen: Integers) -> float:
        """Return Δ of the chosen runs."""
        rows = self.factors[chosen].reshape(-1, self.factors.shape[2])
        p = rows.shape[1] - 1
        matrix = rows.T @ rows + self.known + np.eye(p + 1) / VAGUE**2
        own = np.linalg.solve(matrix[:p, :p], matrix[:p, p])
        return max(0.0, float(matrix[p, p] - matrix[:p, p] @ own - 1.0 / VAGUE**2))


def pairs_of_rivals(
    rivals: Sequence[RivalModel],
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    noise: Noise,
    with_rotation: bool,
    fixed: frozenset[str] = frozenset(),
    kind: RunKind = "load",
    turn: Floats | None = None,
) -> list[PairInformation]:
    """Return what runs bring on every ordered pair of models.

    Parameters
    ----------
    rivals : at least two.
    joints : (N, L) logged joint angles of the runs, rad.
    wrench : (N, K, 6) N and N·m, their load steps.
    setup, with_rotation, fixed, kind, turn : as in `information_of_runs`.
    noise : of one load state, for rivals that have none of their own.

    Raises
    ------
    NoBalanceError : a load is more than the springs of a model hold.
    """
    pairs = []
    for second, rival in enumerate(rivals):
        others = [first for first in range(len(rivals)) if first != second]
        differences = partial(_differences, [rivals[first].robot for first in others], rival.robot)
        runs = information_of_runs(
            rival.robot, joints, wrench, setup, rival.noise or noise, with_rotation, fixed, differences, kind, turn
        )
        known = _known(rival, runs.names, runs.scale)
        for place, first in enumerate(others):
            factors = np.concatenate([runs.factors, runs.further[:, :, place : place + 1]], axis=2)
            pairs.append(PairInformation(first, second, compressed(factors), known))
    return pairs


def separating_design(
    pairs: Sequence[PairInformation], n_runs: int, limit: Repeats | int | None = None, first: Integers | None = None
) -> Design:
    """Return the n runs whose smallest separation of all pairs is largest; its loss is 1/√Δ of that pair.

    Parameters
    ----------
    pairs : of one set of candidates.
    n_runs : how many runs.
    limit : how often one candidate may be measured.
    first : (n_runs,) a design to begin with; None: none is known.
    """
    goal = goal_of_pairs(pairs)
    return best_design(goal.factors, n_runs, goal.criterion, goal.known, goal.wanted, limit, first=first)


def goal_of_pairs(pairs: Sequence[PairInformation], weight: float = 1.0) -> Goal:
    """Return the goal that the smallest separation of all pairs is largest.

    Parameters
    ----------
    pairs : of one set of candidates.
    weight : of the goal in a mix.
    """
    sizes = [pair.factors.shape[2] for pair in pairs]
    heights = [pair.factors.shape[1] for pair in pairs]
    n, p = len(pairs[0].factors), sum(sizes)
    factors, known, rows = np.zeros((n, sum(heights), p)), np.zeros((p, p)), np.zeros((len(pairs), p))
    top = left = 0
    for number, pair in enumerate(pairs):
        height, size = heights[number], sizes[number]
        factors[:, top : top + height, left : left + size] = pair.factors
        known[left : left + size, left : left + size] = pair.known
        rows[number, left + size - 1] = 1.0
        top, left = top + height, left + size
    return Goal(factors, Criterion.WORST, known, rows, weight)


def _differences(others: Sequence[CompliantRobot], robot: CompliantRobot, data: Observations) -> Floats:
    """Return (q, m, n) what other models predict more than one does."""
    own = predicted(robot, data, *rests(robot, data))
    return np.stack([predicted(other, data, *rests(other, data)) - own for other in others])


def _known(rival: RivalModel, names: tuple[str, ...], scale: Floats) -> Floats:
    p = len(names)
    known = np.zeros((p + 1, p + 1))
    own = [k for k, name in enumerate(rival.names) if name in names]
    if own:
        places = [names.index(rival.names[k]) for k in own]
        information = rival.information[np.ix_(own, own)] * scale[places][:, None] * scale[places]
        known[np.ix_(places, places)] = 0.5 * (information + information.T)
    return known
