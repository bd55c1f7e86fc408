"""What ``identify`` and ``validate`` say of friction, typed."""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Number


class Optional(TypedDict):
    """Whether a part of the law that need not be there is seen, and why."""

    seen: bool
    why: str


class Between(TypedDict):
    """What both directions share, N·m: weight, the torque's zero, friction that differs by direction."""

    mean: float
    low: float
    high: float
    weight_possible: bool


class Curve(TypedDict):
    """The fitted curve: rad/s, N·m, and its standard uncertainty."""

    velocity: list[float]
    torque: list[float]
    std: list[float]


class Covariance(TypedDict):
    """Of the estimated parameters, in the order of ``symbols``."""

    symbols: list[str]
    matrix: list[list[float]]


class JointOfFriction(TypedDict):
    """One joint: how it was measured, what is left, N·m; ``n_speeds`` null where no velocity was held."""

    joint: int
    name: str
    method: Literal["steady velocities", "weight and inertia modelled"]
    n_readings: int
    n_speeds: int | None
    lowest_speed: float
    highest_speed: float
    rms: float
    noise: Number
    optional: dict[str, Optional]
    between_directions: Between | None
    curve: Curve
    covariance: Covariance


class Bearing(TypedDict):
    """Friction of a joint's own bearing where the drive's shaft turns with several joints, N·m and N·m·s/rad."""

    joint: int
    coulomb: float
    coulomb_std: float
    viscous: float
    viscous_std: float


class FrictionLack(TypedDict):
    """What is left against what repeats scatter: reduced χ², its degrees of freedom, p-value."""

    statistic: Number
    dof: list[Number]
    p_value: Number


class Friction(TypedDict):
    """Friction of the drives; ``effects`` are the laws that friction runs tell."""

    joints: list[JointOfFriction]
    effects: NotRequired[list[str]]
    lack_of_fit: NotRequired[FrictionLack | None]
    bearings: NotRequired[list[Bearing]]


class FrictionJudged(TypedDict):
    """How friction was judged at speeds that the fit had not seen."""

    scheme: str
    n_readings: int
    rms: dict[str, Number]
    noise: dict[str, Number]
    zero_model: dict[str, Number]
