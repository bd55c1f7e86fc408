"""What ``identify`` answers of several tracked bodies; SI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stiffcal.document_arrays import Matrix
from stiffcal.documents import Number

Component: TypeAlias = Literal["tx", "ty", "tz", "rx", "ry", "rz"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointLineResult:
    """One of a joint's six displacements over the same component of its wrench, joint axes."""

    component: Component
    """Along or about which axis."""
    compliance: Number
    """Of the straight line, m/N or rad/(N·m); None where no load turns it."""
    std: Number
    """Standard uncertainty of the compliance."""
    above_noise: bool
    """Whether the compliance differs from none at all and has a spring's sign."""
    curved: bool
    """Whether a straight line does not do."""
    curve: list[Number]
    """c1, c2, c3 of δ = c1 w + c2 w² + c3 w³, the line that holds."""
    p_curved: float
    """Chance of such a bend where there is none."""
    scatter: Number
    """Standard deviation of single states about the line that holds, m or rad."""
    largest: float
    """The largest displacement that the line that holds gives to these loads, m or rad."""
    n_states: int
    """States that it was fitted to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointByItself:
    """A joint between two tracked bodies."""

    joint: int
    """From 1."""
    between: list[str]
    """The two targets, "base" inboard of all."""
    lines: list[JointLineResult]
    """The six components, translations first."""
    couplings: list[list[str]]
    """(displacement, load) off the diagonal that rise above the noise."""
    matrix: Matrix | None
    """(6, 6) compliance; None where the loads leave directions out."""
    matrix_std: Matrix | None
    """(6, 6) its standard uncertainty."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fullness:
    """Smallest direction over the largest, lengths scaled by 0.5 m."""

    wrench: float
    """Of the wrenches."""
    displacement: float
    """Of the displacements."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianStiffnessResult:
    """The Cartesian stiffness at one pose, about the target, base axes."""

    run: str
    """Name of the run in that pose."""
    target: str
    """The frame that was measured."""
    n_states: int
    """States of the run."""
    equation_15: Matrix
    """(6, 6) by eq. 15 of Schneider et al. (2014), which takes displacements for exact; N/m, N/rad, N·m/m, N·m/rad."""
    from_compliance: Matrix
    """(6, 6) inverse of the compliance that is fitted the other way round."""
    fullness: Fullness
    """How evenly the loads fill all directions."""
    over_noise: float
    """r, variance of the displacement that follows the wrench over that of the rest, in the weakest direction; eq. 15
    draws that direction down to r/(1 + r)."""
