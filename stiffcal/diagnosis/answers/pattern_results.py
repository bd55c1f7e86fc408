"""What `diagnose` answers of fitted laws: a candidate's parameters, and how a joint's compliance varies."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from stiffcal.documents import Number
from stiffcal.measurements.rms import Rms


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateParameter:
    """A parameter of a candidate."""

    symbol: str
    """As in parameter names."""
    value: Number
    """SI; a first estimate, before all other parameters are refitted."""
    unit: str
    """Of the value."""


class FollowedBy(Enum):
    """What a joint's compliance may follow."""

    JOINT_ANGLE = "joint angle"
    JOINT_TORQUE = "joint torque"
    LOAD = "load"
    TIME = "time"
    LAST_MOTION = "last motion"
    """Of absolute places: 1 where the joint came to rest moving with its torque, −1 against it, 0 not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternAlternative:
    """A dependence that explains the remainder as well as the one that is named."""

    joint: int
    """Whose compliance varies, from 1."""
    follows: FollowedBy
    of_joint: int | None
    """Whose angle, torque or motion, from 1; null for load and time."""
    share: float
    """Of the avoidable error in poses left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternPoint:
    """A joint's apparent change of compliance in one run."""

    run: str
    at: float
    """Mean of what is followed in the run: rad, a share of the largest torque, load or time, 1 or −1."""
    compliance: float
    """rad/(N·m), what the run's residuals amount to, in addition to the model's compliance."""
    std: float
    """rad/(N·m), its standard uncertainty, all else known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompliancePattern:
    """A joint's compliance that varies, where nothing in the catalogue accounts for the remainder."""

    joint: int
    """Whose compliance varies, from 1."""
    follows: FollowedBy
    of_joint: int | None
    """Whose angle, torque or motion it follows, from 1; null for load and time."""
    share: float
    """Of the avoidable error in poses left out, that goes with the dependence; of all of it without a known noise."""
    p_value: float
    """Family-wise, over all dependences that were tried."""
    heldout_rms_before: Rms
    """In poses left out of the fit, without the dependence."""
    heldout_rms_after: Rms
    """The same with it."""
    scale: float
    """N·m, N or s, of the largest torque or load or the latest time: the law is in shares of it; 1 for angles."""
    parameters: list[CandidateParameter]
    """Of the law: for an angle q (a cos mq + b sin mq) with m the order, for a last motion a s, else a s + b s²."""
    alternatives: list[PatternAlternative]
    """Those that cannot be distinguished from it, at most four."""
    points: list[PatternPoint]
    """The apparent compliance in each run."""
    curve: list[list[float]]
    """Pairs of what is followed and the law's change of compliance, rad/(N·m), to be drawn with the points."""
