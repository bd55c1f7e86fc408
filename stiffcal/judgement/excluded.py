"""What could not be excluded: how large something at a place would have to be to be found.

An effect of a place is found where its evidence makes up for what it is before: with λ the sum of squares that it would
leave in the readings, in noises and beyond what every hypothesis can make, ½ χ² − ½ log(1 + λ) ≥ −log odds, where χ² of
one degree of freedom about λ is as large as that in nine campaigns of ten: √λ is 1.28 more than the root of what is
needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.numbers import LEAST_LEFT, POWER, SIZE_FOUND, SIZE_PASSES
from stiffcal.model.effect import Instrument


@dataclass(frozen=True)
class ExcludedSize:
    """How large something at a place would have been found."""

    where: str
    """As `stiffcal.judgement.priors.where`."""
    size: float
    """Rms of what it does to the components `Ground.stated`; infinite where an effect there does not show."""
    effect: Candidate
    """Which effect there shows least."""

    @property
    def grows_with_load(self) -> bool:
        """Whether it is larger under larger loads: what moves tracker or target is not."""
        return not isinstance(self.effect.effect, Instrument)


def excluded_sizes(judged: Judged) -> tuple[ExcludedSize, ...]:
    """Return the size of each place where the best set has nothing, of the effect there that shows least."""
    evidence, ground, members = judged.weighed.evidence, judged.ground, judged.members
    key = judged.weighed.best
    left = evidence.left_by(key)
    noise = float(evidence.noise.scale(np.maximum(left[0].square, 0.0))[0]) if left else 1.0
    stated = ground.stated
    taken = {members[i].share.place for i in key}
    found: dict[str, ExcludedSize] = {}
    for number, one in enumerate(members):
        if one.candidate is None or one.share.place in taken:
            continue
        place = one.share.place
        shown = float(np.trace(left[number].gram[0]))
        rows = one.columns.rows
        if shown <= LEAST_LEFT * float(np.sum(rows**2)):
            found[place] = ExcludedSize(place, np.inf, one.candidate)
            continue
        moved = np.array([ground.space.unwhitened(row)[stated] for row in rows])
        if not moved.any():
            continue  # nothing of it is read in the unit in which sizes are stated: angles of clamped motors
        read = max(int(np.count_nonzero(ground.space.data.measured_mask[stated].any(axis=0))), 1)
        size = noise * np.sqrt(_squares_to_find(one.log_prior) / shown * np.sum(moved**2) / read)
        if place not in found or size > found[place].size:
            found[place] = ExcludedSize(place, float(size), one.candidate)
    return tuple(found[place] for place in sorted(found))


def _squares_to_find(log_prior: float) -> float:
    """Return λ that is found in nine campaigns of ten."""
    squares = 1.0
    for _ in range(SIZE_PASSES):
        new = (POWER + np.sqrt(-2.0 * log_prior + np.log1p(squares))) ** 2
        if abs(new - squares) < SIZE_FOUND * new:
            break
        squares = float(new)
    return squares
