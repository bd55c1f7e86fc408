"""What a mistake in load states is, and what a model leaves of them, on which it is tried."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.estimation.decomposition import thin_svd
from stiffcal.estimation.rows import RowSpace
from stiffcal.mistakes.mistake import Mistake
from stiffcal.mistakes.suspect_kinds import SuspectKind

LEAST_OF_MISTAKE = 1e-6
"""Share of a mistake's longest column below which another is made of those before: far above what rounding leaves."""


@dataclass(frozen=True)
class LeftOfStates:
    """What a model leaves of n load states with m readings each."""

    residual: Floats
    """(m, n) measured minus predicted, m and rad."""
    scale: Floats
    """(m, n) one over the standard uncertainty of each reading; 0 where nothing was read."""
    space: RowSpace
    """Noise, and constants of runs."""
    run: Integers
    """(n,) numbers of the states' runs."""
    absolute: Booleans
    """(n,) True for places, of which each is a run."""
    wrench: Floats
    """(6, n) the load as read."""
    response: Floats
    """(m, 6, n) of the readings to that load, m and rad per N and N·m."""
    swept: frozenset[int]
    """Runs that sweep a clamped robot's motor."""
    has_constants: bool
    """Whether runs have zeros of their own: what is off in all of a run's states does not show then."""
    step: int | None
    """The state from which on a step to the end of its run explains most; None where no run can have one."""
    n_runs: int
    """How many runs there are, to choose from."""


@dataclass(frozen=True)
class StateChange:
    """What one mistake does to the readings."""

    runs: tuple[int, ...]
    """Numbers of the runs that it is in."""
    rows: Floats
    """(d, r) whitened columns. Where the size is known one, as it is; else together of rms one over the run."""
    log_share: float
    """Logarithm of the share that this one has of all of its kind, before any reading."""


class StateMistake(Mistake[LeftOfStates, StateChange]):
    """One mistake in load states, judged next to all effects: of all its ways the few that explain most are given."""

    size_is_known: ClassVar[bool] = False
    """Whether the readings that are exchanged say how large it is; else it may be of any size."""
    inside_a_run: ClassVar[bool] = False
    """Whether it begins inside a run, so that one that was set aside may have it …"""
    kind: ClassVar[SuspectKind] = SuspectKind.OFF
    """… what such a run is called then …"""
    likely: ClassVar[str] = ""
    """… and its cure, in words."""

    @abstractmethod
    def words(self, runs: tuple[int, ...]) -> str:
        """Return what happened to runs of these numbers, as a member is named."""


def independent(rows: Floats, count: int) -> Floats:
    """Return directions (d, r) of rows that are not made of each other, together of rms one over so many readings."""
    _, size, axes = thin_svd(rows)
    kept = (axes * size[:, None])[size > LEAST_OF_MISTAKE * max(float(size.max(initial=0.0)), 1e-300)]
    return np.asarray(kept * np.sqrt(count / max(float(np.sum(kept**2)), 1e-300)))
