"""A model at rest, about which members are compared, and their columns about it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import signs_of
from stiffcal.identification.projection import Projection
from stiffcal.identification.regressors import Linearised, Regressor
from stiffcal.judgement.discrepancy import Discrepancy, LouderRun, off_by_run
from stiffcal.judgement.evidence import MemberColumns, NoiseScale, SetEvidence
from stiffcal.judgement.priors import ALONE, SIZE_WEIGHTS, SIZES, RobotScale
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place


@dataclass(frozen=True)
class Ground:
    """A model at rest, about which members are compared."""

    state: Linearised
    """The robot."""
    space: Projection
    """Weights and runs."""
    shared: Shared
    """What every hypothesis has."""
    residual: Floats
    """(m, n) what the model leaves."""
    present: Sequence[PlacedEffect]
    """Members that the robot has already, with values …"""
    derivative: Mapping[tuple[str, Place], Mapping[str, Floats]]
    """… and by effect and place how the readings (m, n) change with each of their amplitudes that was fitted."""
    of_loads: Discrepancy
    """Runs that answer their loads in ways of their own."""
    of_time: Discrepancy
    """Runs that wander."""
    louder: LouderRun | None
    """The run that may be louder than the others."""
    alike: Discrepancy | None
    """Places of sweeps at which states err alike; None where no motor swept: what they leave is noise."""
    noise: NoiseScale
    """How well the weights are known."""

    @cached_property
    def white(self) -> Floats:
        """(r,) whitened residual."""
        return np.asarray(self.space.rows(self.residual[None])[0])

    @property
    def of_noise(self) -> list[int]:
        """Positions in the grid of discrepancies at which no pose has a way of its own: all that is left is noise."""
        return [0, *self.shared.numbers_of(self.alike)]

    def runs_off(self) -> Iterator[tuple[int, Floats]]:
        """Give each run's number and (d, r) whitened columns by which it alone may be off, of rms one over its rows."""
        flat = self.shared.columns[~self.shared.prior[:, :-1].any(axis=0)]
        return off_by_run(self.of_loads, self.of_time, flat)

    def evidence(self, members: Sequence[MemberColumns], residual: Floats | None = None) -> SetEvidence:
        """Return the evidence of sets of members, where what is present already can be taken back.

        Parameters
        ----------
        residual : (r,) whitened, in place of the model's with the members' present parts.
        """
        if residual is None:
            residual = self.white
            for member in members:
                if len(member.present):
                    residual = residual + member.present @ member.rows
        shape = self.space.data.measured.shape
        kind = np.broadcast_to(self.space.data.kind[:, None], shape).ravel()
        free = np.where(self.space.data.measured_mask, 1.0 - self.space.offsets.leverage(), 0.0).ravel()
        return SetEvidence.of(Readings(self.shared, residual, free, kind), members, self.noise)


def columns_of(ground: Ground, regressor: Regressor, scale: RobotScale) -> MemberColumns:
    """Return whitened columns in units of their typical size."""
    effect, place = regressor.effect, regressor.place
    own = dict(zip(regressor.symbols, regressor.columns, strict=True))
    placed = next(
        (
            one
            for one in ground.present
            if (one.effect.name, one.place, one.shape()) == (effect.name, place, dict(regressor.shape))
        ),
        None,
    )
    if placed is not None:
        own |= ground.derivative.get((effect.name, place), {})
    if not own:
        rows = ground.space.rows(regressor.fixed[None])
        return MemberColumns(rows, np.ones(1, dtype=np.bool_), np.ones(1), np.ones(1))
    typical = np.array([scale.typical(effect, place, symbol) for symbol in own])
    rows = ground.space.rows(np.array(list(own.values()))) * typical[:, None]
    low, _ = signs_of([effect.spec(symbol) for symbol in own])
    present = np.zeros(0) if placed is None else np.array([placed.amplitude(symbol) for symbol in own]) / typical
    alone = ALONE if len(rows) > 1 else 0.0
    return MemberColumns(rows, np.isfinite(low) & (low >= 0.0), SIZES, SIZE_WEIGHTS, alone, present)
