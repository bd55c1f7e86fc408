"""What ``identify`` answers of links with rods; SI, beam axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from typing_extensions import TypedDict

from stiffcal.documents import Number
from stiffcal.links.sigma_source import SigmaSource
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import Units

Way: TypeAlias = Literal["links-rigid", "tool-alone", "links-taken-out", "with-rods"]
"""To identify the same load states."""
LINK_COMPLIANCE: Final = (
    (0, 0, "stretch per force along x1", "m/N"),
    (1, 1, "u2 per force along x2", "m/N"),
    (5, 5, "rotation about x3 per moment", "rad/(N*m)"),
    (2, 2, "u3 per force along x3", "m/N"),
    (4, 4, "rotation about x2 per moment", "rad/(N*m)"),
    (3, 3, "twist per moment", "rad/(N*m)"),
)
"""Elements of a link's 6×6 compliance that are printed, those of a beam alone: row, column, words, unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RodFaultResult:
    """A rod that cannot be right."""

    kind: str
    """What is wrong; "unexplained": something contradicts, and no single fault explains it."""
    rods: list[str]
    """Names."""
    size_m: float
    """Rms of what is wrong with these rods' readings, m."""
    alternatives: list[str]
    """Other faults that explain the data as well, in words."""
    why: str
    """What was found and what to do, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TorsionResult:
    """Whether the rods show the link's twist."""

    identifiable: bool
    """Whether the twist is estimated."""
    bound: Number
    """Where it is not: the largest twist that the end can have had, rad; None where nothing bounds it."""
    why: str
    """In words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NotCarried:
    """A load that the rods' shape cannot carry."""

    load: str
    """Which field it makes."""
    relative_error: float
    """Of the estimated displacement of the link's end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkResult:
    """A link with rods: the displacement of its end per wrench there."""

    link: str
    """Its name."""
    rods: list[str]
    """Names of the rods."""
    n_states: int
    """States in which all of them were read."""
    carried: list[str]
    """The fields that the rods carry."""
    spare: int
    """Rods beyond as many as are needed."""
    condition: Number
    """Condition number of the rods' matrix."""
    sigma: Number
    """Standard uncertainty of a rod's reading, m."""
    sigma_source: SigmaSource
    """Where `sigma` is from."""
    displacement_std: list[Number]
    """(6,) standard uncertainty of the end's displacement in one state, m and rad."""
    share_of_tool: Number
    """Of the tool's deflection, which part is the link's."""
    torsion: TorsionResult
    """Whether the rods show the link's twist."""
    compliance_structure: Literal["symmetric", "beam"]
    """Any symmetric matrix, or that of an even beam where the rods leave out a bending moment."""
    compliance: list[list[Number]]
    """(6, 6) m and rad per N and N·m; None where these rods or loads do not give it."""
    compliance_std: list[list[Number]]
    """(6, 6) standard uncertainty."""
    compliance_interval: list[list[list[Number]]]
    """(2, 6, 6) low and high end of the 95 % interval."""
    reduced_chi2: Number
    """Of the readings against the stated uncertainty."""
    not_identifiable: list[str]
    """What is not known of the compliance, in words."""
    not_carried: list[NotCarried]
    """What loads that the rods do not carry do to the estimate."""
    faults: list[RodFaultResult]
    """Rods that cannot be right."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CoupledEstimate:
    """A parameter as one way gives it, SI."""

    value: float
    std: float
    """Standard uncertainty."""
    against_rods: Number
    """Relative difference from tool and rods together."""


# Keys with a hyphen are no names of fields. None where that way does not identify the parameter.
CoupledParameter = TypedDict(
    "CoupledParameter",
    {
        "name": str,
        "links-rigid": CoupledEstimate | None,
        "tool-alone": CoupledEstimate | None,
        "links-taken-out": CoupledEstimate | None,
        "with-rods": CoupledEstimate | None,
    },
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CouplingWay:
    """One way to identify the same load states."""

    way: Way
    """Its name."""
    says: str
    """The same in words."""
    rms: Rms
    """Of the residuals."""
    condition: Number
    """Condition number of the fit."""
    not_identifiable: list[str]
    """Names of parameters."""
    left_out: list[str]
    """Names of parameters that its model does without."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CouplingResult:
    """What measuring without the rods does to every parameter (``identify --coupling``)."""

    links: list[str]
    """Names of the links with rods."""
    ways: list[CouplingWay]
    """The four."""
    parameters: list[CoupledParameter]
    """By each of the ways."""


def compliance_units(link: LinkResult) -> Units:
    """Return the units in which the elements of a link's compliance are shown."""
    return Units((unit, [link.compliance[row][column]]) for row, column, _, unit in LINK_COMPLIANCE)
