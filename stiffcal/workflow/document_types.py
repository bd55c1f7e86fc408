"""What several answers share: errors, places, models."""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.documents import Origin

__all__ = ["Origin"]
from stiffcal.fault_codes import FaultCode

Number = float | None
Matrix = list[list[float]]


class RmsEntry(TypedDict):
    """Square root of the mean squared length of a residual vector, m and rad (N·m for torques)."""

    translation: Number
    rotation: Number
    length: NotRequired[Number]
    motor_angle: NotRequired[Number]
    torque: NotRequired[Number]


class WhereEntry(TypedDict, total=False):
    """Where an effect sits; empty for the set-up."""

    joints: list[int]
    links: list[str]
    pairs: list[list[int]]


class ModelEffect(TypedDict):
    """An effect of a model, with its places."""

    type: str
    joints: NotRequired[list[int]]
    links: NotRequired[list[str]]
    pairs: NotRequired[list[list[int]]]


class Model(TypedDict):
    """What a model holds."""

    balance: Literal["deformed", "first-order"]
    effects: list[ModelEffect]


class Threshold(TypedDict):
    """One threshold, judged; ``held`` null where it cannot be."""

    threshold: str
    where: str
    limit: float
    value: Number
    unit: str
    held: bool | None
    says: str


class FaultEntry(TypedDict):
    """What is wrong with the input."""

    code: FaultCode
    file: str
    place: str
    reason: str
    mend: str
