"""What a judgement asks of readings, of whatever kind: m components in n states, some of which run together."""

from __future__ import annotations

from typing import Protocol

from stiffcal.arrays import Booleans, Floats, Integers


class ReadStates(Protocol):
    """Readings of m components in n states."""

    @property
    def measured_mask(self) -> Booleans:
        """(m, n) True where something was read."""

    @property
    def kind(self) -> Integers:
        """(m,) of each component: readings of one kind have a noise of their own scale."""

    @property
    def run(self) -> Integers:
        """(n,) number of what errs together: the run of each state, or the pass of a moving joint."""

    @property
    def index(self) -> Integers:
        """(n,) number of each state in the campaign."""

    @property
    def absolute(self) -> Booleans:
        """(n,) True for places, of which each is a run."""


class Space(Protocol):
    """Weights of readings, and the constants of their runs."""

    @property
    def data(self) -> ReadStates:
        """The readings."""

    @property
    def scale(self) -> Floats:
        """(m, n) one over the standard uncertainty of each; 0 where nothing was read."""

    @property
    def free(self) -> Floats:
        """(m, n) share of each that the constants leave free; 0 where nothing was read."""

    @property
    def independent(self) -> bool:
        """Whether what moves one component shows in rows of that alone."""

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) whitened rows of (k, m, n), constants taken out."""

    def unwhitened(self, rows: Floats) -> Floats:
        """Return (m, n) readings, constants taken out, of whitened rows (m · n)."""
