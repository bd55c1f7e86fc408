"""A model with values, about which members are compared, and their columns about it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.drift import Drift
from stiffcal.estimation.unknowns import signs_of
from stiffcal.identification.fitting.regressors import Regressor, RegressorMaker
from stiffcal.judgement.discrepancy import Discrepancy, LouderRun, OffRun
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.lingering_noise import LingeringNoise
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import ALL_SHAPES, ALONE, SIZE_WEIGHTS, SIZES
from stiffcal.judgement.priors import UsualSizes
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.space import Space
from stiffcal.judgement.tails import Readings
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Place


class CheckKind(Enum):
    """What is compared with what chance leaves."""

    TRANSLATION = "translation against the noise"
    ROTATION = "rotation against the noise"
    LENGTH = "length against the noise"
    TORQUE = "torque against the noise"
    RUN = "a run against the others"


@dataclass(frozen=True)
class Ground(ABC):
    """A model with values, about which members are compared."""

    state: RegressorMaker
    """Makes what effects do to the readings of the model."""
    space: Space
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
    lingering: LingeringNoise | None
    """Noise of which some is left in the next reading; None where readings are means of several."""
    louder: LouderRun | None
    """The run that may be louder than the others."""
    noise: NoiseScale
    """How well the weights are known."""
    alike: Discrepancy | None = field(default=None, kw_only=True)
    """Places of sweeps at which states err alike; None where no motor swept: what they leave is noise."""
    with_present: dict[tuple[tuple[str, Place], ...], Shared] = field(default_factory=dict, compare=False, kw_only=True)
    """What every set has where some effects of the model are in all of them."""

    most_shapes: ClassVar[int] = ALL_SHAPES
    """Combinations of shape parameters up to which a law is tried."""

    @cached_property
    def white(self) -> Floats:
        """(r,) whitened residual."""
        return np.asarray(self.space.rows(self.residual[None])[0])

    @property
    def of_noise(self) -> list[int]:
        """Positions in the grid of discrepancies at which no pose has a way of its own: all that is left is noise."""
        return [0, *self.shared.numbers_of(self.lingering), *self.shared.numbers_of(self.alike)]

    @property
    def log_weights(self) -> float:
        """Logarithm of the determinant of the weights, as far as these are of the model."""
        return 0.0

    @abstractmethod
    def runs_off(self) -> Iterator[OffRun]:
        """Give how each run alone may be off."""

    def evidence(
        self,
        members: Sequence[MemberColumns],
        residual: Floats | None = None,
        shared: Shared | None = None,
        jobs: int = 1,
    ) -> SetEvidence:
        """Return the evidence of sets of members, where what is present already can be taken back.

        Parameters
        ----------
        residual : (r,) whitened, in place of the model's with the members' present parts.
        shared : what every set has, where that is more than what every hypothesis has.
        jobs : as of `SetEvidence.of`.
        """
        if residual is None:
            residual = self.white
            for member in members:
                if len(member.present):
                    residual = residual + member.present @ member.rows
        kind = np.broadcast_to(self.space.data.kind[:, None], self.space.free.shape).ravel()
        return SetEvidence.of(
            Readings(shared or self.shared, residual, self.space.free.ravel(), kind), members, self.noise, jobs
        )

    def uneven_noise(self) -> Floats:
        """Return (n,) by what squares of the noise exceed what each state is taken to have, run by run."""
        return np.ones(self.space.free.shape[1])

    @property
    @abstractmethod
    def drift(self) -> Drift:
        """What the model leaves in the course of runs."""

    @property
    @abstractmethod
    def stated(self) -> Integers:
        """Positions of the components in whose unit sizes are stated."""

    @property
    @abstractmethod
    def checked(self) -> Mapping[CheckKind, Integers]:
        """Positions of the components that are held against the noise, by what they are."""

    def steps(self) -> tuple[int, float | None]:
        """Return the number of states at which a step may begin, and the state where it explains most."""
        return 0, None


def is_of(regressor: Regressor, placed: PlacedEffect) -> bool:
    """Return whether a regressor is that of an effect of the model, in its form and shape."""
    effect, own = regressor.effect, placed.effect
    return (effect.name, effect.parameters, regressor.place, dict(regressor.shape)) == (
        own.name,
        own.parameters,
        placed.place,
        placed.shape(),
    )


def columns_of(ground: Ground, regressor: Regressor, scale: UsualSizes) -> MemberColumns:
    """Return whitened columns in units of their typical size."""
    effect, place = regressor.effect, regressor.place
    own = dict(zip(regressor.symbols, regressor.columns, strict=True))
    placed = next((one for one in ground.present if is_of(regressor, one)), None)
    if placed is not None:
        own |= ground.derivative.get((effect.name, place), {})
    if not own:
        # without a parameter: the log says all, and the model has it or not
        rows, present = ground.space.rows(regressor.fixed[None]), np.zeros(0) if placed is None else np.ones(1)
        return MemberColumns(rows, np.ones(1, dtype=np.bool_), np.ones(1), np.ones(1), present=present)
    typical = np.array([scale.typical(effect, place, symbol, regressor.shape) for symbol in own])
    rows = ground.space.rows(np.array(list(own.values()))) * typical[:, None]
    low, _ = signs_of([effect.spec(symbol) for symbol in own])
    present = np.zeros(0) if placed is None else np.array([placed.amplitude(symbol) for symbol in own]) / typical
    alone = ALONE if len(rows) > 1 else 0.0
    return MemberColumns(rows, np.isfinite(low) & (low >= 0.0), SIZES, SIZE_WEIGHTS, alone, present)
