"""Steps of Gauss–Newton that raise the sum of squares are shortened.

A law with a corner (a knee, a play) has another slope on the other side of it, and where the model leaves much more
than the noise its curvature, which Gauss–Newton does not know, counts as well: a step may then go so far beyond the
least sum of squares that the next one returns, and so on without end. The sum along such a step is taken as a parabola
through its value and slope at the start and its value at the end (Nocedal and Wright, Numerical Optimization, 2006,
section 3.5); the lowest place of the parabola is tried next.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.identifiability import Identifiability
from stiffcal.estimation.triangular import Reduced

# A step whose parabola is lowest before this share of it has gone too far: the next ones would return by half of it or
# more, each time.
TOO_FAR = 2.0 / 3.0
# A step is not shortened to less than this share of itself at once: the parabola is a guess.
SHORTEST = 0.25


@dataclass(frozen=True)
class TakenStep:
    """A step from one set of amplitudes to the next."""

    start: Floats
    """(p,) amplitudes before it."""
    end: Floats
    """(p,) amplitudes after all of it."""
    reduced: Reduced
    """The problem linearised at the start."""
    checked: Identifiability
    """What the data distinguish there; what they do not is held neutral."""
    change: float
    """Length of all of it, in standard uncertainties, whatever their correlations, per parameter."""
    comparable: bool
    """False where the step makes a parameter neutral: that raises the sum of squares rightly."""
    share: float = 1.0
    """Of the step, how much was taken."""

    @classmethod
    def of(
        cls,
        start: Floats,
        end: Floats,
        reduced: Reduced,
        checked: Identifiability,
    ) -> TakenStep:
        """Describe a whole step."""
        held = checked.left_at_neutral
        step = cls(start, end, reduced, checked, 0.0, np.array_equal(start[held], end[held]))
        return replace(step, change=step.distance(end))

    def distance(self, other: Floats) -> float:
        """Return how far other amplitudes (p,) are from the start, in standard uncertainties per parameter."""
        n_free = max(1, len(self.start) - int(self.checked.left_at_neutral.sum()))
        return float(np.linalg.norm(self.reduced.factor @ (other - self.start)) / np.sqrt(n_free))

    @property
    def reached(self) -> Floats:
        """(p,) amplitudes where it ends."""
        return np.asarray(self.start + self.share * (self.end - self.start))

    @property
    def left(self) -> float:
        """Length of what was taken, in standard uncertainties per parameter."""
        return self.share * self.change

    def shortest(self) -> TakenStep:
        """Return the step shortened as much as is done at once: where it ends there is no sum of squares."""
        return replace(self, share=self.share * SHORTEST)

    @property
    def began(self) -> float:
        """Sum of squares where it starts."""
        return self.reduced.cost(np.zeros_like(self.start))

    def shortened(self, squares: float) -> TakenStep | None:
        """Return the step shortened where it has raised the sum of squares; None where it stands.

        Parameters
        ----------
        squares : the sum of squares where the step ended, of the same readings and weights as where it started.
        """
        if not self.comparable:
            return None
        slope = -2.0 * float(self.reduced.target @ (self.reduced.factor @ (self.end - self.start))) * self.share
        rise = squares - self.began
        if slope >= 0.0:
            return None
        lowest = slope / (2.0 * (slope - rise))
        return replace(self, share=self.share * max(lowest, SHORTEST)) if 0.0 < lowest < TOO_FAR else None
