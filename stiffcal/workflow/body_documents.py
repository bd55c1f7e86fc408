"""What `identify` says of several tracked bodies, typed."""

from __future__ import annotations

from typing import Literal

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Matrix, Number


class JointLine(TypedDict):
    """One of a joint's six displacements over the same component of its wrench, joint axes; m/N or rad/(N·m).

    ``curve``: c1, c2, c3 of δ = c1 w + c2 w² + c3 w³, the line that holds; ``scatter``, ``largest``: m or rad.
    """

    component: Literal["tx", "ty", "tz", "rx", "ry", "rz"]
    compliance: Number
    std: Number
    above_noise: bool
    curved: bool
    curve: list[Number]
    p_curved: float
    scatter: Number
    largest: float
    n_states: int


class JointByItself(TypedDict):
    """A joint between two tracked bodies; ``matrix`` the 6×6 compliance, null where loads leave directions out.

    ``couplings``: (displacement, load) beside the diagonal that rise above the noise.
    """

    joint: int
    between: list[str]
    lines: list[JointLine]
    couplings: list[list[str]]
    matrix: Matrix | None
    matrix_std: Matrix | None


class Fullness(TypedDict):
    """Smallest over largest direction of the wrenches and of the displacements, lengths scaled by 0.5 m."""

    wrench: float
    displacement: float


class CartesianStiffness(TypedDict):
    """At one pose, about the target, base axes: by eq. 15 of paper 001, and from the compliance the other way round.

    ``over_noise``: r, variance of the displacement that follows the wrench over that of the rest, in the weakest
    direction; eq. 15 draws that direction down to r/(1 + r).
    """

    run: str
    target: str
    n_states: int
    equation_15: Matrix
    from_compliance: Matrix
    fullness: Fullness
    over_noise: float
