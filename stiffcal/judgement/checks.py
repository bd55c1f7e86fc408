"""Whether the best set would make readings like these: checks of what it leaves, against what chance leaves.

The residual of the best set is what its columns, each with its prior, and each run's constants cannot make. Its squares
have the expected value tr(I − H), H the set's share of each reading: by kind of reading they are compared with the
noise, run by run with those of all other runs (posterior predictive checks; Gelman, Carlin, Stern, Dunson, Vehtari and
Rubin, Bayesian Data Analysis, 2013, chapter 6).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.judge import f_tail
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.rows_off import off_mask

CHANCE = 0.003
"""Probability below which what is left is no chance: of three checks one fails in a hundred sound campaigns."""

FREE_ENOUGH = 0.1
"""Share of a reading that the set leaves free, from which its square shows tails."""


class CheckKind(Enum):
    """What is compared."""

    TRANSLATION = "translation against the noise"
    ROTATION = "rotation against the noise"
    RUN = "a run against the others"


@dataclass(frozen=True)
class Check:
    """What the best set leaves somewhere, against what chance leaves."""

    kind: CheckKind
    """What is compared."""
    ratio: float
    """Mean square over what is expected, 1 where nothing is left."""
    p_value: float
    """Probability of so large a ratio by chance; of several runs, of the largest of so many."""
    run: int | None = None
    """The run that scatters most."""

    @property
    def failed(self) -> bool:
        """Whether what is left is no chance."""
        return self.p_value < CHANCE


def checks_of(judged: Judged) -> tuple[Check, ...]:
    """Return the checks of the best set; against the noise where it is known."""
    left = _LeftOver.of(judged)
    return (*left.against_noise(judged), *left.run_by_run())


@dataclass(frozen=True)
class _LeftOver:
    """Squares that the best set leaves, and how many are expected, reading by reading."""

    square: Floats
    """(m, n)."""
    expected: Floats
    """(m, n), for noise as it is known."""
    run: Integers
    """(n,) number of each state's run."""
    off: Booleans
    """(n,) True for states that are off, or of runs that are: they follow no model."""

    @classmethod
    def of(cls, judged: Judged) -> _LeftOver:
        """Return it for a judgement."""
        ground, members = judged.ground, judged.best
        shape = ground.space.data.measured.shape
        columns = [one.columns for one in members]
        sizes = _sizes(judged)
        rows = np.concatenate(
            [ground.shared.columns, *(one.rows * size[:, None] for one, size in zip(columns, sizes, strict=True))]
        )
        p, o = len(ground.shared.columns), len(ground.shared.prior)
        prior = np.zeros((o + len(rows) - p, len(rows) + 1))
        prior[:o, :p], prior[:o, -1] = ground.shared.prior[:, :-1], ground.shared.prior[:, -1]
        prior[o:, p:-1] = np.eye(len(rows) - p)
        target = ground.white + sum(
            (one.present @ one.rows for one in columns if len(one.present)), np.zeros(rows.shape[1])
        )
        whole = np.concatenate([rows, prior[:, :-1].T], axis=1)
        basis, _ = np.linalg.qr(whole.T / np.maximum(np.linalg.norm(whole, axis=1), 1e-300))
        goal = np.concatenate([target, prior[:, -1]])
        left = (goal - basis @ (basis.T @ goal))[: rows.shape[1]]
        taken = np.sum(basis[: rows.shape[1]] ** 2, axis=1)
        free = np.where(ground.space.data.measured_mask, 1.0 - ground.space.offsets.leverage(), 0.0)
        runs = ground.space.data.run
        off = off_mask(runs, ground.space.data.index, (off for one in members for off in one.off))
        if ground.louder is not None and judged.louder > 0.5:
            off |= runs == ground.louder.run
        return cls((left**2).reshape(shape), free - taken.reshape(shape), runs, off)

    @property
    def tails(self) -> float:
        """What a degree of freedom is worth: 1 for normal noise, less where it has tails.

        The variance of squares is κ − 1, and 2 for normal noise. Each run is taken over its own size: where one
        scatters more than others, that is no tail.
        """
        taken = (self.expected > FREE_ENOUGH) & ~self.off
        z = np.sqrt(np.where(taken, self.square / np.where(taken, self.expected, 1.0), 0.0))
        for number in np.unique(self.run):
            own = self.run == number
            z[:, own] /= max(float(np.sqrt(np.sum(z[:, own] ** 2) / max(np.count_nonzero(taken[:, own]), 1))), 1e-300)
        kurtosis = float(np.sum(z**4) / max(np.count_nonzero(taken), 1))
        return min(2.0 / max(kurtosis - 1.0, 1e-300), 1.0)

    def against_noise(self, judged: Judged) -> Iterator[Check]:
        """Give the checks by kind of reading."""
        noise = judged.fit.noise
        if noise is None:
            return
        tails = self.tails
        dof = tails * (judged.ground.noise.known or noise.dof)
        for kind, rows in ((CheckKind.TRANSLATION, slice(0, 3)), (CheckKind.ROTATION, slice(3, 6))):
            expected = float(self.expected[rows][:, ~self.off].sum())
            if expected > 1.0:
                ratio = float(self.square[rows][:, ~self.off].sum()) / expected
                yield Check(kind, ratio, f_tail(ratio, tails * expected, dof))

    def run_by_run(self) -> Iterator[Check]:
        """Give the check of the run that scatters most."""
        numbers = np.unique(self.run[~self.off])
        squares = np.array([self.square[:, self.run == number].sum() for number in numbers])
        expected = np.array([self.expected[:, self.run == number].sum() for number in numbers])
        tried = [k for k in range(len(numbers)) if expected[k] > 1.0 and expected.sum() - expected[k] > 1.0]
        if len(tried) < 2:
            return
        others = expected.sum() - expected
        ratios = [squares[k] / expected[k] * others[k] / (squares.sum() - squares[k]) for k in tried]
        worth = self.tails
        chances = [
            f_tail(ratio, worth * expected[k], worth * others[k]) for ratio, k in zip(ratios, tried, strict=True)
        ]
        worst = int(np.argmin(chances))
        p_value = 1.0 - (1.0 - chances[worst]) ** len(tried)
        yield Check(CheckKind.RUN, float(ratios[worst]), p_value, int(numbers[tried[worst]]))


def _sizes(judged: Judged) -> list[Floats]:
    """Return (q,) the best sizes of each member of the best set where no pose answers in a way of its own."""
    evidence, key = judged.weighed.evidence, judged.weighed.best
    _, sizes = evidence.best_sizes(key)
    return [evidence.members[i].scales[size] for i, size in zip(key, sizes[0], strict=True)]
