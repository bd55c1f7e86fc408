"""What a mistake in the course of absolute places is, and what a fit leaves of them, on which it is tried."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.mistakes.mistake import Mistake
from stiffcal.mistakes.suspect_kinds import SuspectKind


@dataclass(frozen=True)
class LeftOfPlaces:
    """What a fit leaves of N rows with m readings each, whitened; rows of other runs first."""

    residual: Floats
    """(m, N) whitened."""
    motion: Floats
    """(m, N, 6) what a shift (m) and a turn (rad) of all places about their centre, base axes, make in each row."""
    basis: Floats
    """(m, N, r) orthonormal, of what the model's parameters make."""
    first: int
    """The first of the N rows that is of an absolute run; these follow in the order in which they were measured."""
    index: Integers
    """(N − first,) their indices among the campaign's states."""
    n_states: int
    """How many states the campaign has."""
    dof: int
    """Degrees of freedom of the fit."""


@dataclass(frozen=True)
class MovedRows:
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


class PlacesMistake(Mistake[LeftOfPlaces, MovedRows]):
    """One mistake from a row on, which is given where it is certain; the one with the smaller rank is tried first."""

    kind: ClassVar[SuspectKind]
    """How it is answered."""

    @abstractmethod
    def words(self, moved: MovedRows, rows: Sequence[str]) -> tuple[str, str]:
        """Return what was found, and the likely cause with its cure.

        Parameters
        ----------
        moved : as it was found. rows : the two rows between which it happened and the likeliest, in words.
        """

    @abstractmethod
    def rows_in_words(self, count: int) -> str:
        """Return so many rows on one side of it, which are left out, as they are listed."""
