"""What the answers of all kinds of experiment share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from stiffcal.documents import Number
from stiffcal.identification.answers.fit_results import IdentifiedParameter, UnidentifiedParameters
from stiffcal.identification.noise.noise_source import NoiseSource
from stiffcal.model.summary import EffectInModel
from stiffcal.validation.results import ErrorSlice, SliceBy

if TYPE_CHECKING:
    import pyarrow as pa


class IdentifiedModel(Protocol):
    """The result of ``identify``, as far as kinds of experiment ask it."""

    @property
    def parameters(self) -> Sequence[IdentifiedParameter]:
        """In the model's order."""

    def section(self, kind: str) -> object:
        """Return the section of a kind of experiment, by the kind's name; None where there is none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldoutSection:
    """How one kind of experiment was judged on data that the fit did not use; it stands in ``validate``."""

    scheme: str
    """How it was done, in words."""
    n_readings: int
    """Readings that were judged."""
    rms: dict[str, Number]
    """By measure: "torque", N·m."""
    noise: dict[str, Number]
    """Scatter of repeats by measure; a measure is left out where they are too few."""
    zero_model: dict[str, Number]
    """What a model without parameters leaves, by measure."""


@dataclass(frozen=True, kw_only=True)
class ExperimentFit:
    """What one kind of experiment adds to the answer of ``identify``."""

    name: str
    """Of its section in the document: the kind's."""
    section: object
    """That section, a result."""
    parameters: list[IdentifiedParameter] = field(default_factory=list)
    """To be added to those of the load states."""
    not_identifiable: list[UnidentifiedParameters] = field(default_factory=list)
    """Likewise."""
    effects: list[EffectInModel] = field(default_factory=list)
    """Of the model, those that this experiment alone identifies."""
    rms: dict[str, float | None] = field(default_factory=dict)
    """By measure: "torque", N·m."""
    noise: dict[str, float | None] = field(default_factory=dict)
    """Likewise; empty where it is not known."""
    noise_source: NoiseSource = "none"
    n_runs: int = 0
    """Runs that it rests on."""
    n_readings: int = 0
    """Number of readings that it rests on."""
    reduced_chi2: float | None = None
    """Of its own fit."""
    condition: float | None = None
    """Of its own fit."""
    expected: str = ""
    """One sentence on what error to expect."""
    warnings: list[str] = field(default_factory=list)
    """In words."""
    tables: dict[str, pa.Table] = field(default_factory=dict)
    """To be stored, by name."""
    free: list[str] = field(default_factory=list)
    """Names of the parameters that were estimated."""
    covariance: Sequence[Sequence[Number]] = field(default_factory=list)
    """Of these, square."""


@dataclass(frozen=True, kw_only=True)
class ExperimentValidation:
    """What one kind of experiment adds to the answer of ``validate``."""

    name: str
    """Of its section in the document: the kind's."""
    scheme: str
    """How it was judged, in words."""
    rms: dict[str, float | None]
    """By measure: "torque", N·m."""
    max: dict[str, float | None]
    """The largest residual, likewise."""
    noise: dict[str, float | None]
    """What repeats scatter, likewise."""
    relative: dict[str, float | None]
    """By measure, 1."""
    zero_model: dict[str, float | None]
    """What a model without parameters leaves, by measure."""
    by: dict[SliceBy, list[ErrorSlice]] = field(default_factory=dict)
    """The error in parts of the data, by what they are cut by."""
    section_scheme: str = ""
    """How it was judged, as the experiment's own section writes it."""
    n_readings: int = 0
    """How many were judged."""
    warnings: list[str] = field(default_factory=list)
    tables: dict[str, pa.Table] = field(default_factory=dict)
    """To be stored, by name."""

    @property
    def section(self) -> HeldoutSection:
        """The experiment's section of ``validate``."""
        return HeldoutSection(
            scheme=self.section_scheme,
            n_readings=self.n_readings,
            rms=self.rms,
            noise=self.noise,
            zero_model=self.zero_model,
        )
