"""What a fit looks for: p unknowns with their bounds, and what is known of them before the measurement.

Nobody else reads bounds and prior deviations from a law's parameters.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole, ParameterSpec


@dataclass(frozen=True)
class ParameterColumn:
    """One free parameter of a fit."""

    placed: int
    """Number of the placed effect in the robot's list."""
    symbol: str
    """The parameter's symbol."""
    role: ParameterRole
    """Amplitude, nonlinear or set-up."""


@dataclass(frozen=True)
class OpenBefore:
    """What no reading of a campaign can determine, known before the fit."""

    causes: Mapping[str, Undetermined] = field(default_factory=dict)
    """Full name to why."""
    common_scale: tuple[str, ...] = ()
    """Full names of moments and compliances with one unknown scale (`stiffcal.identification.fitting.load_scale`); the
    first keeps its value.
    """

    def with_causes(self, names: Collection[str], cause: Undetermined) -> OpenBefore:
        """Return it with more parameters; a cause that is known already stays."""
        return replace(self, causes={**dict.fromkeys(sorted(names), cause), **self.causes})


@dataclass(frozen=True)
class Unknowns:
    """p unknowns of a fit, in the units of what the laws multiply with (`ParameterSpec.amplitude_of`)."""

    names: tuple[str, ...]
    """Full names."""
    lower: Floats
    """(p,) smallest possible values, −∞ where there is no bound."""
    upper: Floats
    """(p,) largest possible values, ∞ where there is no bound."""
    nonlinear: Booleans
    """(p,) True for those by which a law bends: where such a one takes part in what is open, it alone is unknown, as
    the law's size is still known with the shape at its best value.
    """
    tolerance: Floats
    """(p,) standard uncertainty before any measurement: an estimate that is no better is none. Infinite: not known."""
    prior: Floats
    """(p,) standard deviation of the law's own that the rows of a fit hold already, infinite where there is none: data
    that determine an unknown no better leave it free, and unknown.
    """
    open_before: OpenBefore = OpenBefore()
    """What is open whatever was read."""

    @classmethod
    def plain(
        cls,
        names: Sequence[str],
        lower: Floats | None = None,
        upper: Floats | None = None,
        nonlinear: Booleans | None = None,
        open_before: OpenBefore | None = None,
    ) -> Unknowns:
        """Return unknowns of which nothing but bounds (none: ±∞) is known before."""
        p = len(names)
        return cls(
            tuple(names),
            np.full(p, -np.inf) if lower is None else lower,
            np.full(p, np.inf) if upper is None else upper,
            np.zeros(p, dtype=np.bool_) if nonlinear is None else nonlinear,
            np.full(p, np.inf),
            np.full(p, np.inf),
            open_before or OpenBefore(),
        )

    @classmethod
    def of(
        cls, robot: CompliantRobot, columns: Sequence[ParameterColumn], open_before: OpenBefore | None = None
    ) -> Unknowns:
        """Return the unknowns of a robot's free parameters."""
        specs = [robot.placed[column.placed].effect.spec(column.symbol) for column in columns]
        lower, upper = bounds_of(specs)
        return cls(
            tuple(robot.placed[column.placed].parameter_name(column.symbol) for column in columns),
            lower,
            upper,
            np.array([column.role is ParameterRole.NONLINEAR for column in columns], dtype=np.bool_),
            np.array([np.inf if spec.tolerance is None else spec.tolerance for spec in specs], dtype=np.float64),
            np.array([np.inf if spec.prior is None else spec.prior for spec in specs], dtype=np.float64),
            open_before or OpenBefore(),
        )

    def __len__(self) -> int:
        """Return p."""
        return len(self.names)

    @cached_property
    def widest(self) -> Floats:
        """(p,) the largest size that is possible; infinite without an upper bound."""
        return np.where(np.isfinite(self.upper), np.maximum(np.abs(self.upper), np.abs(self.lower)), np.inf)

    @cached_property
    def keep_values(self) -> Booleans:
        """(p,) True for those that keep their value where they are held; the others are neutral, zero."""
        keeping = set(self.open_before.common_scale[:1])
        keeping |= {name for name, cause in self.open_before.causes.items() if cause is Undetermined.GAIN_OF_LOAD}
        return self.nonlinear | np.array([name in keeping for name in self.names], dtype=np.bool_)

    def where(self, names: Collection[str]) -> Booleans:
        """Return (p,) True for those with one of these names."""
        return np.array([name in names for name in self.names], dtype=np.bool_)

    def select(self, numbers: Sequence[int]) -> Unknowns:
        """Return some of the unknowns, by their positions."""
        kept = list(numbers)
        return Unknowns(
            tuple(self.names[k] for k in kept),
            self.lower[kept],
            self.upper[kept],
            self.nonlinear[kept],
            self.tolerance[kept],
            self.prior[kept],
            self.open_before,
        )

    def steps_within(self, values: Floats) -> tuple[Floats, Floats]:
        """Return (p,) how far down and how far up each can go from its value; never the other way."""
        return np.minimum(self.lower - values, 0.0), np.maximum(self.upper - values, 0.0)


def amplitude_bounds(spec: ParameterSpec) -> tuple[float, float]:
    """Return the bounds of what the law multiplies with."""
    if spec.inverse:
        return (1.0 / spec.upper if np.isfinite(spec.upper) else 0.0), (
            1.0 / spec.lower if spec.lower > 0.0 else np.inf
        )
    return spec.lower - spec.neutral, spec.upper - spec.neutral


def bounds_of(specs: Sequence[ParameterSpec]) -> tuple[Floats, Floats]:
    """Return lower and upper bounds (q,) of what laws multiply with."""
    bounds = np.array([amplitude_bounds(spec) for spec in specs], dtype=np.float64).reshape(-1, 2)
    return bounds[:, 0], bounds[:, 1]


def signs_of(specs: Sequence[ParameterSpec]) -> tuple[Floats, Floats]:
    """Return bounds (q,) by sign alone: sizes of laws that cannot be negative are not.

    For candidates: one that is best beyond what is possible is no better explanation at the edge of it.
    """
    signed = [spec.inverse or (spec.lower >= 0.0 and spec.role is ParameterRole.AMPLITUDE) for spec in specs]
    return np.where(signed, 0.0, -np.inf), np.full(len(specs), np.inf)


def free_columns(robot: CompliantRobot, fixed: frozenset[str] = frozenset()) -> list[ParameterColumn]:
    """Return the robot's free parameters in order; ``fixed`` holds full names that keep their values."""
    return [
        ParameterColumn(number, spec.symbol, spec.role)
        for number, placed_effect in enumerate(robot.placed)
        for spec in placed_effect.effect.parameters
        if placed_effect.parameter_name(spec.symbol) not in fixed and not spec.discrete
    ]


def amplitudes(robot: CompliantRobot, columns: Sequence[ParameterColumn]) -> Floats:
    """Return (p,) the free parameters' present values, as the fit counts them."""
    return np.array([robot.placed[c.placed].amplitude(c.symbol) for c in columns], dtype=np.float64)


def with_estimates(robot: CompliantRobot, columns: Sequence[ParameterColumn], amplitude: Floats) -> CompliantRobot:
    """Return the robot with amplitudes (p,) of its free columns."""
    values: dict[str, float] = {}
    for column, a in zip(columns, amplitude, strict=True):
        placed_effect = robot.placed[column.placed]
        spec = placed_effect.effect.spec(column.symbol)
        values[placed_effect.parameter_name(column.symbol)] = spec.value_of(float(a))
    return robot.with_values(values)
