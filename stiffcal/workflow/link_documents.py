"""What `identify` and `check` say of links with rods, typed."""

from __future__ import annotations

from typing import Literal

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Number, Rms


class LinkTorsion(TypedDict):
    """Whether the rods tell the link's twist; else a twist (rad) that they would have shown."""

    identifiable: bool
    bound: Number
    why: str


class RodFault(TypedDict):
    """A rod that cannot be right."""

    kind: Literal["loose", "swapped-sign", "exchanged", "drifting", "warming", "unexplained"]
    rods: list[str]
    size_m: float
    alternatives: list[str]
    why: str


class NotCarried(TypedDict):
    """A load that the rods' shape cannot carry, and what it does to the estimate of the link's end."""

    load: str
    relative_error: float


class MeasuredLink(TypedDict):
    """A link with rods: displacement of its end per wrench there, beam axes, m and rad per N and N·m.

    ``compliance_structure``: any symmetric matrix, or that of an even beam where the rods leave out a bending moment.
    """

    link: str
    rods: list[str]
    n_states: int
    carried: list[str]
    spare: int
    condition: Number
    sigma: Number
    sigma_source: Literal["stated", "residuals", "none"]
    displacement_std: list[Number]
    share_of_tool: Number
    torsion: LinkTorsion
    compliance_structure: Literal["symmetric", "beam"]
    compliance: list[list[Number]]
    compliance_std: list[list[Number]]
    compliance_interval: list[list[list[Number]]]
    reduced_chi2: Number
    not_identifiable: list[str]
    not_carried: list[NotCarried]
    faults: list[RodFault]


class Estimate(TypedDict):
    """A parameter as one way tells it; ``against_rods``: relative difference from tool and rods together."""

    value: float
    std: float
    against_rods: Number


# by way: "links-rigid", "tool-alone", "links-taken-out", "with-rods"; null where that way cannot tell the parameter
CoupledParameter = TypedDict(
    "CoupledParameter",
    {
        "name": str,
        "links-rigid": Estimate | None,
        "tool-alone": Estimate | None,
        "links-taken-out": Estimate | None,
        "with-rods": Estimate | None,
    },
)


class Way(TypedDict):
    """One way to identify the same load states; ``left_out``: parameters that its model does without."""

    way: Literal["links-rigid", "tool-alone", "links-taken-out", "with-rods"]
    says: str
    rms: Rms
    condition: Number
    not_identifiable: list[str]
    left_out: list[str]


class Coupling(TypedDict):
    """What measuring without the rods does to every parameter (``identify --coupling``)."""

    links: list[str]
    ways: list[Way]
    parameters: list[CoupledParameter]
