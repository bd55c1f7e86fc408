"""What ``identify`` answers: the fit of the load states, and what each other kind of experiment adds to it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal, TypeAlias

from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
from stiffcal.documents import NOT_PROMISED, CommandResult, KeyIf, ManyKeys, Number, OrAbsent, Origin
from stiffcal.identification.answers.agreement_results import Agreement
from stiffcal.identification.answers.fit_results import (
    CorrelatedParameters,
    DualQuaternionFit,
    GeometryTaken,
    IdentifiedParameter,
    NoisePerAxis,
    RejectedState,
    UnidentifiedParameters,
)
from stiffcal.identification.answers.geometry_results import GeometryFound
from stiffcal.identification.bodies.body_results import CartesianStiffnessResult, JointByItself
from stiffcal.identification.bodies.link_results import CouplingResult, LinkResult
from stiffcal.identification.noise.noise_source import NoiseSource
from stiffcal.kinds import section_types
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import ModelSummary
from stiffcal.reduction.registration.frames import RegistrationSummary

Loss: TypeAlias = Literal["linear", "huber"]


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifyResult(CommandResult):
    """Answer of ``identify``; SI."""

    schema: Literal["stiffcal/identify/1"] = "stiffcal/identify/1"
    registration: OrAbsent[RegistrationSummary] = None
    """What is left between the kinematics and the places of the frames that were estimated; None where none was."""
    model: ModelSummary
    """What was fitted."""
    parameters: list[IdentifiedParameter]
    """In the model's order."""
    shifted: OrAbsent[list[str]] = None
    """Names of values that adding what the model lacks moves beyond their 95 % intervals: they are not to be used;
    absent where this fit is not diagnosed.
    """
    n_states: int
    """Load states that were used."""
    n_runs: int
    """Runs that were used."""
    n_readings: OrAbsent[int] = None
    """Readings of the other experiments, where there are no load states."""
    rms: Rms
    """Of the residuals."""
    noise: Rms | None
    """What the instruments scatter, in the same measure; None where it is not known."""
    noise_source: NoiseSource
    """Where `noise` is from."""
    noise_per_axis: Annotated[NoisePerAxis | None, KeyIf("has_states"), NOT_PROMISED] = None
    """What a single reading scatters; None where it is not known."""
    reduced_chi2: Number
    """Weighted sum of squares over degrees of freedom; None where the noise is not known."""
    dof: Annotated[int | None, KeyIf("", null=False), NOT_PROMISED] = None
    """Degrees of freedom of the load states' fit."""
    std_scaled_by_reduced_chi2: Annotated[bool | None, KeyIf("", null=False), NOT_PROMISED] = None
    """Whether standard uncertainties were scaled by the reduced χ², the noise not being known."""
    condition: Number
    """Condition number of the observation matrix."""
    not_identifiable: list[UnidentifiedParameters]
    """What these data do not identify."""
    rejected: list[RejectedState]
    """Load states that were set aside."""
    free_parameters: Annotated[list[str], NOT_PROMISED]
    """Names of the p parameters that `covariance` is of."""
    covariance: Annotated[list[list[Number]], NOT_PROMISED]
    """(p, p) of what was estimated: of stiffness-like parameters one over the value."""
    covariance_from_geometry: Annotated[OrAbsent[list[list[Number]]], NOT_PROMISED] = None
    """(k, k) the part of `covariance` that the geometry's tolerance makes, of the first k parameters."""
    geometry: OrAbsent[GeometryTaken | GeometryFound] = None
    """Of load states, how well the geometry is known; of absolute poses, what it was found to be; None of neither."""
    correlation: Annotated[list[CorrelatedParameters], NOT_PROMISED]
    """Strongest first."""
    iterations: Annotated[int | None, KeyIf("", null=False), NOT_PROMISED] = None
    """Steps of the load states' fit."""
    links: OrAbsent[list[LinkResult]] = None
    """Links with rods."""
    expected_rms: Rms | None
    """The error to expect in new poses; None where it is not known."""
    expected_error: str
    """The same in words."""
    sections: Annotated[dict[str, object], ManyKeys(section_types)] = field(default_factory=dict)
    """What kinds of experiment add, by the kind's name."""
    agreement: OrAbsent[list[Agreement]] = None
    """How kinds of experiment agree on the parameters that each determines alone; None where there is one kind, or
    nothing that two determine."""
    joints_by_themselves: OrAbsent[list[JointByItself]] = None
    """Joints between tracked bodies."""
    cartesian_stiffness: OrAbsent[list[CartesianStiffnessResult]] = None
    """At poses where the loads fill all directions."""
    suspects: OrAbsent[list[Suspect]] = None
    """Runs and states that disagree with all the others; None where there are no load states."""
    suspects_not_checked: OrAbsent[RunsNotChecked] = None
    """What was not compared with the other runs, and why, where there is anything."""
    loss: Annotated[Loss, NOT_PROMISED] = "linear"
    """Of the fit."""
    key: Annotated[str, NOT_PROMISED] = ""
    """A hash of all that went into the fit; "" before it is stored."""
    fit_id: Annotated[str, NOT_PROMISED] = ""
    """Its number in the history; "" before it is stored."""
    dual_quaternions: OrAbsent[DualQuaternionFit] = None
    """Joint springs as dual quaternions (Li et al. 2019), where that was asked for."""
    coupling: OrAbsent[CouplingResult] = None
    """What measuring without the rods does, where that was asked for."""
    origin: OrAbsent[Origin] = None
    """From whom the fit comes."""

    @property
    def has_states(self) -> bool:
        """Whether load states were fitted."""
        return self.n_readings is None

    def section(self, kind: str) -> object:
        """Return the section of a kind of experiment, by the kind's name; None where there is none."""
        return self.sections.get(kind)

    def parameter(self, name: str) -> IdentifiedParameter:
        """Return a parameter by its full name; KeyError where there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    def values(self) -> dict[str, float]:
        """Return parameter values by full name; those that are not known are left out."""
        return {parameter.name: parameter.value for parameter in self.parameters if parameter.value is not None}

    def robot_values(self) -> dict[str, float]:
        """Return what the fitted robot has, by full name: `values`, and what stands in the fit for known sums."""
        stand_in = {parameter.name: parameter.in_fit for parameter in self.parameters if parameter.in_fit is not None}
        return self.values() | stand_in
