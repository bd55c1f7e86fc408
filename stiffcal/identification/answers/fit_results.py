"""What ``identify`` answers of a fit; SI, null for what is not known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from stiffcal.documents import NOT_PROMISED, KeyIf, Number, OrAbsent
from stiffcal.estimate import Estimate
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.identification.fitting.geometry_source import GeometrySource
from stiffcal.measurements.rms import Applicable
from stiffcal.model.summary import Where
from stiffcal.quantity import DriftFollows, Quantity, quantity_of


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifiedParameter:
    """A parameter of the model as these data give it."""

    name: str
    """``effect.place.symbol``."""
    effect: str
    """The effect's name."""
    where: Where
    """Where it acts."""
    value: Number
    """In `unit`; None where these data do not identify it."""
    std: Number
    """Standard uncertainty; None where it is fixed, not identified, or at a limit of its range."""
    interval: list[Number] | None
    """Both ends of the 95 % interval, None where one is open, as at a limit of the range other than 0; None where the
    value is fixed or not identified.
    """
    unit: str
    """Of the value."""
    fixed: bool
    """Whether the model file gives the value."""
    identifiable: bool
    """Whether these data distinguish it from the other parameters."""
    at_bound: Annotated[bool, NOT_PROMISED] = False
    """Whether the value is at the limit of its range."""
    rests_on: Annotated[OrAbsent[list[str]], NOT_PROMISED] = None
    """Names of parameters at a limit of their range, other than 0, that make half of its variance or more: how they are
    bounded decides its value; None where there is none."""
    poorly_known: Annotated[bool, NOT_PROMISED] = False
    """Whether the 95 % interval is nearly as wide as the value, or wider."""
    remark: Annotated[str | None, KeyIf("", null=False), NOT_PROMISED] = None
    """What else is to be known of it; None where its kind of experiment makes no remarks."""
    stiffness: Applicable = None
    """Of a compliance: one over it, N·m/rad or N/m, NaN where it is not known or the value is 0; None of others."""
    stiffness_std: Applicable = None
    """Standard uncertainty of the stiffness; NaN and None as there."""
    stiffness_interval: Annotated[list[Number] | None, KeyIf("is_compliance")] = None
    """Both ends of the stiffness's 95 % interval."""
    above_noise: OrAbsent[bool] = None
    """Whether it exceeds three standard uncertainties; None where that question does not apply."""
    from_geometry: OrAbsent[float] = None
    """Share of the variance that the tolerance of the robot's geometry makes, 0 to 1; None where that is not known."""
    in_fit: OrAbsent[float] = None
    """Of a parameter that these data do not identify alone: what stands in the fit for the combination that is known,
    in `unit`; None of others, and of those at 0 there."""
    drift_follows: OrAbsent[DriftFollows] = None
    """Of a rate of drift: what these data count it by; None of others."""
    includes: OrAbsent[list[str]] = None
    """Parameters that stay at 0 by convention and move the targets in every pose as this one does, so that its value is
    the sum: "frame.tracker.z", the height of the base, in a shift of joint 2. None where there are none.
    """

    @property
    def quantity(self) -> Quantity:
        """What the value is of."""
        return quantity_of(self.unit, self.drift_follows)

    @property
    def estimate(self) -> Estimate:
        """The value in `unit`, with what is to be known of it."""
        return self._estimate(self.quantity, self.value, self.std, self.interval)

    @property
    def as_read(self) -> Estimate:
        """The parameter as people read it: of a compliance the stiffness."""
        if not self.is_compliance:
            return self.estimate
        value, std = self.known_stiffness, self.known_stiffness_std
        return self._estimate(self.quantity.reciprocal(), value, std, self.stiffness_interval)

    def _estimate(self, quantity: Quantity, value: Number, std: Number, interval: list[Number] | None) -> Estimate:
        if interval is None and value is not None and std is not None:
            interval = Estimate.of(value, std).interval
        is_open = self.stiffness_interval is not None and self.stiffness_interval[1] is None
        is_firm = not self.fixed and not self.at_bound and self.above_noise is not False
        return Estimate(
            value=value,
            interval=None if self.fixed else interval,
            std=std,
            quantity=quantity,
            at_bound=self.at_bound,
            is_fixed=self.fixed,
            is_identifiable=self.identifiable and self.value is not None,
            is_significant=self.above_noise is not False,
            is_poorly_determined=is_firm and self.value is not None and (self.poorly_known or is_open),
            rests_on=tuple(self.rests_on or ()),
            includes=tuple(name for name in self.includes or () if name.startswith("frame.")),
        )

    @property
    def is_compliance(self) -> bool:
        """Whether the parameter has a stiffness."""
        return self.stiffness is not None

    @property
    def known_stiffness(self) -> Number:
        """The stiffness; None where it is not known or does not apply."""
        return _known(self.stiffness)

    @property
    def known_stiffness_std(self) -> Number:
        """Standard uncertainty of the stiffness; None where it is not known or does not apply."""
        return _known(self.stiffness_std)


def _known(value: Number) -> Number:
    return None if value is None or value != value else value


@dataclass(frozen=True, slots=True, kw_only=True)
class GeometryTaken:
    """How well the robot's geometry is known, as the parameters' uncertainties hold it."""

    length_sigma: float
    """m, standard deviation of every length between joint frames."""
    angle_sigma: float
    """rad, of every angle between joint frames."""
    source: GeometrySource
    """What it is from: the robot file, the default, or the default scaled by the misfit of absolute poses."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UnidentifiedParameters:
    """Parameters that these data do not distinguish from each other or from nothing."""

    parameters: list[str]
    """Their names."""
    known: str | None
    """The combination of them that is known, in words."""
    value: Annotated[Number, NOT_PROMISED] = None
    """Of that combination."""
    std: Annotated[Number, NOT_PROMISED] = None
    """Standard uncertainty of that value."""
    reason: str
    """Why, in words."""
    cause: Annotated[Undetermined | None, NOT_PROMISED] = None
    """Why; None where it is a matter of one joint's motion or curve, which `reason` states."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RejectedState:
    """A load state that was not used."""

    run: str
    """Name of its run."""
    row: int
    """Data row of the table, or number of the dwell, from 1."""
    why: str
    """In words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoisePerAxis:
    """Standard uncertainty of one reading along one axis."""

    translation: Number
    """m"""
    rotation: Number
    """rad"""
    force: Number
    """N"""
    moment: Number
    """N·m"""
    gauge: OrAbsent[float] = None
    """m, where gauges were read."""
    length: OrAbsent[float] = None
    """m, where rods were read."""
    motor_angle: OrAbsent[float] = None
    """rad, where motors of clamped runs were read."""
    force_clamped: OrAbsent[float] = None
    """N, of clamped states, where it differs from that of the others."""
    moment_clamped: OrAbsent[float] = None
    """N·m, of clamped states, where it differs from that of the others."""
    translation_absolute: OrAbsent[float] = None
    """m, of absolute poses, where it is stated apart from that of load states."""
    rotation_absolute: OrAbsent[float] = None
    """rad, likewise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrelatedParameters:
    """Two parameters whose estimates hang together."""

    parameters: list[str]
    """Both names."""
    correlation: float
    """Their coefficient of correlation, above 0.5 in size."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComplianceInTwoForms:
    """A joint's compliance in the matrix form and in dual quaternions, rad/(N·m)."""

    name: str
    """The parameter's."""
    matrix: float
    """By the matrix form."""
    dual_quaternion: float
    """By dual quaternions, with the same weights."""
    unweighted_in_metres: Number
    """By eq. 35 of Li et al. (2019) as printed, lengths in m; None where orientation is not measured everywhere."""
    unweighted_in_millimetres: Number
    """The same, lengths in mm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DualQuaternionFit:
    """Joint springs identified in both forms (``identify --dual-quaternions``)."""

    largest_relative_difference: float
    """Between the two forms."""
    parameters: list[ComplianceInTwoForms]
    """The compliances that the fit identifies."""
