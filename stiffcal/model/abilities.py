"""What few effects can do besides what all of their kind do: asked for with isinstance."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Geometry, NodeLoads, Observed, Place, Term, Values
from stiffcal.model.scalar_laws import BalancingSpring


class KnownSlopes(ABC):
    """A law that bends with its shape parameters, and knows how; others are differentiated by difference."""

    @abstractmethod
    def shape_slopes(self, place: Place, chain: Chain, loads: NodeLoads, values: Values) -> Sequence[Term]:
        """Return the derivatives of the law by all shape parameters, as terms with their symbols.

        Parameters
        ----------
        place : where.
        chain : the robot.
        loads : what the nodes carry.
        values : of shape parameters and amplitudes, by symbol.
        """


class FiniteShift(ABC):
    """An instrument whose shift of the readings bends: `observation_columns` is its slope at the displacement."""

    @abstractmethod
    def observation_shift(self, place: Place, observed: Observed, values: Values) -> Floats:
        """Return (B, 6, n) the finite shift of the observation."""


class ParallelSpring(Geometry, ABC):
    """A spring in parallel with the drive of its place's joint."""

    @abstractmethod
    def balancing_spring(self, place: Place, chain: Chain, values: Values) -> BalancingSpring | None:
        """Return the spring as data, for controllers' code; None where its rate has no value."""
