"""What a fit found: parameters with uncertainty, residuals, and what the data cannot determine."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Floats
from stiffcal.estimation.identifiability import Ambiguity
from stiffcal.estimation.parameters import Parameter
from stiffcal.estimation.unknowns import ParameterColumn, free_columns
from stiffcal.identification.derivatives.observation import ModelAtRest
from stiffcal.identification.fitting.geometry_prior import GeometryPrior
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Noise, Whitening
from stiffcal.identification.noise.weights import raw_whitening
from stiffcal.identification.readings.observations import Observations
from stiffcal.model.assembled.composite import CompliantRobot


@dataclass(frozen=True)
class Fit:
    """The result of an identification."""

    robot: CompliantRobot
    """The model with the estimated values (parameters that are not identifiable at their neutral value)."""
    parameters: tuple[Parameter, ...]
    """All of them, in the model's order."""
    covariance: Floats
    """(p, p) of the free, identifiable amplitudes, in the order of ``free_names``."""
    free_names: tuple[str, ...]
    """p full names."""
    condition: float
    """Condition number of the whitened observation matrix with columns of unit length."""
    ambiguities: tuple[Ambiguity, ...]
    """Sets of parameters that cannot be distinguished."""
    noise: Noise | None
    """Instrument noise, or None where it cannot be determined."""
    noise_length: dict[str, float | None]
    """{"translation", "rotation"}, with rods "length": rms length of the noise, wrench noise included; None where not
    known.
    """
    scaled: bool
    """True where standard uncertainties were scaled by the reduced χ², the noise not being known."""
    reduced_chi2: float | None
    """Weighted sum of squares over degrees of freedom; None where the noise is not known."""
    dof: int
    """Degrees of freedom of the fit."""
    residual: Floats
    """(m, n) measured minus predicted, each run's offset taken out, base axes."""
    predicted: Floats
    """(m, n) model's displacement plus the run's offset."""
    data: Observations
    """The observations that were fitted."""
    iterations: int
    """Gauss–Newton steps taken."""
    whitening: Whitening
    """Weights of ``data`` in the last step: those of the noise, lower for wild readings where these count less."""
    left_at_neutral: frozenset[str] = frozenset()
    """Full names of parameters left at their neutral value because nothing distinguishes them."""
    geometry: GeometryPrior | None = None
    """How well the geometry is known, where ``covariance`` holds what it makes; None where it counts as exact."""
    covariance_from_geometry: Floats | None = None
    """(p, p) the part of ``covariance`` that the geometry's tolerance makes."""
    last_step: float | None = None
    """The last step, in standard uncertainties per parameter, where the fit did not settle; None where it did."""

    @property
    def fixed(self) -> frozenset[str]:
        """Full names of parameters that kept the model file's values."""
        return frozenset(parameter.name for parameter in self.parameters if parameter.fixed)

    @property
    def columns(self) -> list[ParameterColumn]:
        """The parameters that the fit solved for: neither fixed nor left at their neutral value."""
        return free_columns(self.robot, self.fixed | self.left_at_neutral)

    def linearised(
        self,
        weights: Whitening | Noise | None = None,
        at_rest: ModelAtRest | None = None,
        data: Observations | None = None,
    ) -> LoadRows:
        """Return the rows about the estimates: the only way from a fit to columns, residual, priors and bounds.

        Parameters
        ----------
        weights : to use in place of the fit's own.
        at_rest : the fitted robot at rest, where it is at hand.
        data : observations in place of those that were fitted, some of which took no part; ``weights`` are of them.
        """
        return LoadRows.about(
            self.robot, self.data if data is None else data, self.columns, weights or self.whitening, at_rest
        )

    def residual_of(self, data: Observations) -> tuple[Projection, Floats]:
        """Return the weights of other observations by the fit's noise, and (m, n) what the model leaves of them.

        Each run's offset is taken out.
        """
        weights = raw_whitening(data, None) if self.noise is None else self.noise
        rows = LoadRows.about(self.robot, data, (), weights)
        return rows.space, rows.space.centred(rows.stack)[0]

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by its full name; KeyError where there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)
