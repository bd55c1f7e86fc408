"""What ``diagnose``, ``improve`` and ``compare`` answer, typed."""

from __future__ import annotations

from typing import Any, Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Model, Number, Origin, Rms, Where


class EffectAt(TypedDict):
    """An effect at a place."""

    effect: str
    where: Where


class Missing(TypedDict):
    """An effect to add, with those that look the same in these poses."""

    effect: str
    where: Where
    alternatives: list[EffectAt]


class LackOfFit(TypedDict):
    """What is left against what repeats scatter: F statistic, its two degrees of freedom, p-value."""

    statistic: Number
    dof: list[Number]
    p_value: Number


class FittedValue(TypedDict):
    """A parameter of a candidate, as fitted with it."""

    symbol: str
    value: Number
    unit: str


class Finding(TypedDict):
    """A candidate for the next single step; ``explains`` is the share of the avoidable error that goes."""

    effect: str
    where: Where
    verdict: Literal["supported", "possible", "rejected"]
    explains: Number
    size_m: Number
    p_value: Number
    heldout_rms_before: Rms
    heldout_rms_after: Rms
    heldout_rms_after_choosing: Rms | None
    confidence: Number
    parameters: list[FittedValue]
    alternatives: list[EffectAt]
    why: str


class CouldBe(TypedDict):
    """An effect that alone fits all poses, at any of these places, where the poses are too few to tell which it is."""

    effect: str
    where: Where


class NotTried(TypedDict):
    """An effect that these data cannot show, and what it would need."""

    effect: str
    needs: str


class Remainder(TypedDict):
    """What the unexplained error follows."""

    follows: str
    share: Number
    seen: str


class Pace(TypedDict):
    """How much was tried, the catalogue beside one model after another, and how fast."""

    models: int
    candidates: int
    signatures: int
    seconds: Number
    candidates_per_second: Number


class Diagnose(TypedDict):
    """Answer of ``diagnose``; ``adequate`` null where the noise is not known."""

    schema: Literal["stiffcal/diagnose/1"]
    warnings: list[str]
    adequate: bool | None
    noise: Rms | None
    rms: Rms
    lack_of_fit: LackOfFit | None
    missing: list[Missing]
    could_be: list[CouldBe]
    findings: list[Finding]
    next_measurement: dict[str, Any] | None
    not_tried: list[NotTried]
    unexplained: bool | None
    structure: list[Remainder]
    heldout_rms_after_choosing: Rms
    pace: Pace
    summary: str
    origin: NotRequired[Origin]


class Step(TypedDict):
    """A rung of the ladder."""

    action: str
    effect: str | None
    where: Where
    heldout_rms: Rms | None
    noise: Rms | None


class Improve(TypedDict):
    """Answer of ``improve``."""

    schema: Literal["stiffcal/improve/1"]
    warnings: list[str]
    steps: list[Step]
    model: Model
    adequate: bool | None
    unexplained: bool | None
    missing: list[Missing]
    structure: list[Remainder]
    summary: str
    heldout_rms: Rms
    noise: Rms | None
