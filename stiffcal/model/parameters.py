"""Parameters of effects: symbol, unit, bounds, and how a law depends on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stiffcal.arrays import Floats

Values = Mapping[str, float]


class ParameterRole(Enum):
    """How the model depends on a parameter."""

    AMPLITUDE = "amplitude"
    NONLINEAR = "shape"
    SETUP = "set-up"


@dataclass(frozen=True)
class ParameterSpec:
    """One parameter of an effect."""

    symbol: str
    """Its name in the model file, e.g. ``c``."""
    unit: str
    """SI, as printed."""
    meaning: str
    """In words."""
    lower: float
    """Lower bound of possible values."""
    upper: float
    """Upper bound of possible values."""
    typical: float
    """A size met on industrial robots."""
    source: str
    """Where ``typical`` is from."""
    role: ParameterRole = ParameterRole.AMPLITUDE
    """Amplitude, nonlinear or set-up."""
    inverse: bool = False
    """True where the amplitude in the law is 1 / value (a stiffness or flexural rigidity is reported, and its inverse
    is estimated, because the displacement is linear in that).
    """
    compliance: bool = False
    """True where ``1 / value`` is a stiffness that people want to read."""
    discrete: bool = False
    """True where only some values make sense (an order, the number of a state): such a parameter is tried value by
    value (`Effect.nonlinear_grid`), never by a derivative.
    """
    neutral: float = 0.0
    """The value that changes nothing: 0, of a gain 1. The amplitude is counted from there."""
    scales_load: bool = False
    """True where it multiplies the whole load, as all compliances together would: it is known only where a known
    weight or torque acts in a law that is not straight.
    """
    tolerance: float | None = None
    """What is known of it before any measurement, as a standard uncertainty: an estimate that is no better does not
    count as identifiable. None: the bounds alone decide.
    """
    meaning_along: str | None = None
    """In words at a prismatic joint, where the law holds along its axis; None: as ``meaning`` says."""
    prior: float | None = None
    """Standard deviation about the neutral value before any measurement, which the fit counts as a reading: data that
    determine it no better leave it free, and it is not reported. None: nothing is known.
    """
    reversal: bool = False
    """True of the distance, rad, between the rests of a joint after motion one way and the other: what is predicted
    without the direction of the last motion is the middle.
    """
    along: int | None = None
    """The component of the node (`TX` to `RZ`) whose own compliance it is: displacement over load along the same axis,
    all of it, at any load; None elsewhere. Joints that are measured by themselves are compared with these.
    """

    @property
    def size(self) -> float:
        """A usual size of it, for steps of differences; 1 of a parameter that is typically zero, such as a phase."""
        return abs(self.typical) or 1.0

    def amplitude_of(self, value: float) -> float:
        """Return what the law multiplies with at a value of the parameter."""
        return 1.0 / value if self.inverse else value - self.neutral

    def value_of(self, amplitude: float) -> float:
        """Return the parameter's value at an amplitude; infinite where a stiffness has none left."""
        if self.inverse:
            return 1.0 / amplitude if amplitude > 0.0 else np.inf
        return float(self.neutral + amplitude)


def usual_grid(parameters: Iterable[ParameterSpec]) -> dict[str, Floats]:
    """Return a tenth to ten times the typical value of each shape parameter, within its bounds."""
    return {
        spec.symbol: np.clip(spec.typical * np.array([0.1, 0.3, 1.0, 3.0, 10.0]), spec.lower, spec.upper)
        for spec in parameters
        if spec.role is ParameterRole.NONLINEAR
    }
