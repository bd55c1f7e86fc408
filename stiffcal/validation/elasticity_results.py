"""Whether absolute poses show that the joints give, as answers state it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stiffcal.documents import Number

JointVerdict: TypeAlias = Literal[
    "identified",
    "unknown-scale",
    "no-torque",
    "not-above-zero",
    "error-not-lower",
    "like-eccentricity",
    "differs-by-region",
]
ElasticityVerdict: TypeAlias = Literal["identified", "partly-identified", "not-identified"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointElasticity:
    """Whether places show that one joint gives."""

    joint: int
    """From 1."""
    verdict: JointVerdict
    """``identified``, or why not."""
    why: str
    """In words."""
    payload_kg: Number
    """Mass at the flange in half of such poses that would show it to 20 %, kg; None where it is identified, where no
    weight at the flange turns it, and where that were more than the robot's own mass.
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class Elasticity:
    """Whether places show that the joints give."""

    verdict: ElasticityVerdict
    """Of all joints that the model lets give."""
    why: str
    """In words, with what to measure."""
    payload_kg: Number
    """The smallest mass at the flange that would show one joint more, kg; None where none would."""
    joints: list[JointElasticity]
    """Each joint whose compliance the model estimates."""
