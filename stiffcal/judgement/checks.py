"""Whether the best set would make readings like these: checks of what it leaves, against what chance leaves.

The residual of the best set is what its columns, each with its prior, and each run's constants cannot make. Its squares
have the expected value tr(I − H), H the set's share of each reading: by kind of reading they are compared with the
noise, run by run with those of all other runs (posterior predictive checks; Gelman, Carlin, Stern, Dunson, Vehtari and
Rubin, Bayesian Data Analysis, 2013, chapter 6).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.scans.lack_of_fit import f_tail
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.judgement.ground import CheckKind
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.numbers import CHANCE, NAMED, WORTH_OF_NEIGHBOURS
from stiffcal.judgement.rows_off import off_mask
from stiffcal.judgement.tails import Tail, tails_of


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
    kind: Integers
    """(m,) of the readings."""
    uneven: Floats
    """(n,) squares of like states over their noise, run by run: beyond one where some scatter more than most."""
    run: Integers
    """(n,) number of each state's run."""
    off: Booleans
    """(n,) True for states that are off, or of runs that are: they follow no model."""
    tail: Tail
    """How single readings scatter."""
    independent: float
    """What a square is worth next to those before it in its run."""

    @classmethod
    def of(cls, judged: Judged) -> _LeftOver:
        """Return it for a judgement: squares as they count next to the tails of the noise."""
        ground, readings = judged.ground, judged.weighed.evidence.readings
        inner, number = judged.weighed.evidence.inner, judged.noise_number
        left, free = readings.left(inner, judged.weighed.best, _sizes(judged), number)
        data = ground.space.data
        off = off_mask(data.run, data.index, (off for one in judged.best for off in one.off))
        if ground.louder is not None and judged.louder > NAMED:
            off |= data.run == ground.louder.run
        taken = ~np.broadcast_to(off, data.measured_mask.shape).ravel()
        tails = tails_of(left[taken], free[taken], readings.kind[taken], ground.noise.known)
        tail = max(tails, key=lambda one: tails[one])
        square = left**2 * tail.weights(left**2 / np.maximum(free, 1e-300), readings.kind)
        shape = data.measured_mask.shape
        return cls(
            square.reshape(shape),
            free.reshape(shape),
            data.kind,
            ground.uneven_noise(),
            data.run,
            off,
            tail,
            judged.drift.independent,
        )

    def against_noise(self, judged: Judged) -> Iterator[Check]:
        """Give the checks by kind of reading."""
        noise = judged.fit.noise
        if noise is None:
            return
        dof = judged.ground.noise.known or self.independent * self.tail.worth_plain * noise.dof
        worth = self.independent * self.tail.worth
        for kind, rows in judged.ground.checked.items():
            expected = float(self.expected[rows][:, ~self.off].sum())
            if expected > 1.0:
                ratio = float(self.square[rows][:, ~self.off].sum()) / expected
                yield Check(kind, ratio, f_tail(ratio, worth * expected, dof))

    def swept(self, numbers: Integers) -> Booleans:
        """Return which runs, by number, hold readings of clamped motors alone."""
        return np.array([not self.expected[self.kind != MOTOR][:, self.run == number].any() for number in numbers])

    def run_by_run(self) -> Iterator[Check]:
        """Give the check of the run that scatters most."""
        # each kind of reading has a noise of its own, and a run may hold one kind alone
        variance = np.array([self.tail.variance.get(kind, 1.0) for kind in self.kind.tolist()])[:, None] * self.uneven
        numbers, place = np.unique(self.run, return_inverse=True)
        left = np.unique(place[~self.off])
        numbers = numbers[left]
        squares, expected = (
            np.bincount(place, part.sum(axis=0))[left] for part in (self.square / variance, self.expected)
        )
        tried = [k for k in range(len(numbers)) if expected[k] > 1.0 and expected.sum() - expected[k] > 1.0]
        if len(tried) < 2:
            return
        others = expected.sum() - expected
        # the noise of a sweep is that of its own like states, and no better known than these show it
        known = np.where(self.swept(numbers), np.minimum(others, WORTH_OF_NEIGHBOURS * expected), others)
        ratios = [squares[k] / expected[k] * others[k] / (squares.sum() - squares[k]) for k in tried]
        worth = self.independent * self.tail.worth
        chances = [f_tail(ratio, worth * expected[k], worth * known[k]) for ratio, k in zip(ratios, tried, strict=True)]
        worst = int(np.argmin(chances))
        p_value = 1.0 - (1.0 - chances[worst]) ** len(tried)
        yield Check(CheckKind.RUN, float(ratios[worst]), p_value, int(numbers[tried[worst]]))


def _sizes(judged: Judged) -> Floats:
    """Return (q,) the best sizes of the columns of the best set where no pose answers in a way of its own."""
    evidence, key = judged.weighed.evidence, judged.weighed.best
    _, sizes = evidence.best_sizes(key)
    return np.concatenate(
        [np.zeros(0), *(evidence.members[i].scales[k] for i, k in zip(key, sizes[judged.noise_number], strict=True))]
    )
