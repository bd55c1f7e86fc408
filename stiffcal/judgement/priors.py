"""All that is assumed before any reading: how many effects are missing, where, of which kind, and how large.

The numbers are in `stiffcal.judgement.numbers`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.geometry_nuisance import USUAL_SAG
from stiffcal.judgement.forms import spring_symbol
from stiffcal.judgement.numbers import (
    BEND,
    CONTRADICTED,
    DOUBTED_ROW,
    DOUBTED_RUN,
    EXPECTED_EFFECTS,
    SETUP_MISTAKE,
    SPRING,
    TYPICAL_COMPLIANCE,
    TYPICAL_TORQUE,
    UNLISTED,
)
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, NodeLoads, Place, Values
from stiffcal.model.laws.drives import drive_torque

JOINT_SPRING, JOINT_FRICTION = "joint-compliance", "joint-friction"
COMMON = frozenset({JOINT_SPRING, JOINT_FRICTION, "frame", "link-geometry", "joint-offset"})
"""Effects that every hypothesis has where the model has them: springs, friction, frames, geometry that is asked for."""


_OF_SETUP = {
    "base-compliance": "base", "tool-compliance": "tool", "fixture-compliance": "tool", "thermal-drift": "time",
    "seat-shift": "time", "clock-offset": "time",
}  # fmt: skip


NO_SHAPE: Values = {}
"""Of an effect without shape parameters."""


def where(effect: Effect, place: Place) -> str:
    """Return the place of the robot or of the set-up to which an effect at its place belongs."""
    if place.kind == "setup":
        return _OF_SETUP.get(effect.name, "instrument")
    if place.kind == "pairs":
        return f"joint {place.joints[-1]}"
    return f"joint {place.joints[0]}" if place.joints else f"link {place.label}"


class MemberKind(Enum):
    """What a member is."""

    EFFECT = "effect"
    UNLISTED = "unlisted law"
    MISTAKE = "mistake in the data"
    ROW = "reading that is off"
    SETUP = "mistake in the set-up"
    SETTING = "setting that is contradicted"


@dataclass(frozen=True)
class Share:
    """What a member is, before any reading."""

    place: str
    """As `where`."""
    family: str
    """Members of a family share what the family has."""
    kind: MemberKind
    """Effect of the catalogue, law that nobody has written down, or mistake."""
    of_part: bool
    """Whether the place is a joint or a link: what is there is one group."""


def log_odds(shares: Sequence[Share], expected: float = EXPECTED_EFFECTS) -> Floats:
    """Return the log odds (k,) of each of k members.

    Of effects and laws: places alike, families within a place, forms within a family; a form or a shape more moves no
    other place.

    Parameters
    ----------
    expected : effects that are missing of all these, beyond the present model.
    """
    settings = sum(share.kind is MemberKind.SETTING for share in shares)
    of_kind = {
        MemberKind.ROW: DOUBTED_ROW,
        MemberKind.SETUP: SETUP_MISTAKE,
        MemberKind.SETTING: CONTRADICTED / max(settings, 1),
    }
    odds = np.array([_log_odds(of_kind.get(share.kind, DOUBTED_RUN)) for share in shares])
    laws = [k for k, share in enumerate(shares) if share.kind in (MemberKind.EFFECT, MemberKind.UNLISTED)]
    odds[laws] = _of_laws([shares[k] for k in laws], expected)
    return odds


def log_odds_of_doubt(row: bool) -> float:
    """Return the log odds that a run, or a row of it, is off."""
    return _log_odds(DOUBTED_ROW if row else DOUBTED_RUN)


def _log_odds(p: float) -> float:
    return float(np.log(p / (1.0 - p)))


def _of_laws(shares: Sequence[Share], expected_in_all: float) -> Floats:
    places = {share.place for share in shares}
    families: dict[tuple[str, MemberKind], set[str]] = defaultdict(set)
    forms: dict[tuple[str, MemberKind, str], int] = defaultdict(int)
    for share in shares:
        families[share.place, share.kind].add(share.family)
        forms[share.place, share.kind, share.family] += 1
    per_place = expected_in_all / max(len(places), 1)
    odds = []
    for share in shares:
        if share.kind is MemberKind.EFFECT and share.family in (JOINT_SPRING, JOINT_FRICTION):
            odds.append(_log_odds(SPRING))
            continue
        own = families[share.place, share.kind]
        part = UNLISTED if share.kind is MemberKind.UNLISTED else 1.0 - UNLISTED
        if (share.place, MemberKind.UNLISTED) not in families:
            part = 1.0
        expected = per_place * part / len(own) / forms[share.place, share.kind, share.family]
        odds.append(np.log(expected / (1.0 - expected)))
    return np.array(odds)


class UsualSizes(Protocol):
    """How large effects usually are on a robot."""

    def typical(self, effect: Effect, place: Place, symbol: str, shape: Values = NO_SHAPE) -> float:
        """Return the typical size of an amplitude, in its own unit (rigidities: of the inverse)."""


@dataclass(frozen=True)
class RobotScale:
    """How soft and how loaded a robot is, against those of the catalogue's typical sizes."""

    compliance: float
    """Its joints' over `TYPICAL_COMPLIANCE` …"""
    of_joint: Floats
    """(J,) … and each joint's own, where its spring is known; else as soft as all."""
    torque: Floats
    """(J,) largest torque of each drive over `TYPICAL_TORQUE`."""

    @classmethod
    def of(cls, robot: CompliantRobot, loads: NodeLoads) -> RobotScale:
        """Return it for a robot with values, under the loads of a campaign."""
        chain = robot.chain
        springs = {
            placed.place.joints[0]: compliance
            for placed in robot.placed
            if placed.place.kind == "joints" and placed.place.joints[0] not in chain.prismatic_joints
            if (compliance := _compliance(placed)) > 0.0
        }
        softness = float(np.exp(np.mean(np.log(list(springs.values()))))) / TYPICAL_COMPLIANCE if springs else 1.0
        joints = range(1, chain.n_joints + 1)
        of_joint = [springs[k] / TYPICAL_COMPLIANCE if k in springs else softness for k in joints]
        torque = [float(np.abs(drive_torque(chain, loads.wrench, k)).max()) for k in joints]
        return cls(softness, np.array(of_joint), np.maximum(torque, 1e-6) / TYPICAL_TORQUE)

    def usual_weight(self, chain: Chain) -> tuple[float, float]:
        """Return the standard deviations of a link's mass, kg, and first moment, kg·m, where none is stated."""
        reach = float(np.sum(np.linalg.norm(chain.fixed[:, :3, 3], axis=1)) + np.linalg.norm(chain.flange[:3, 3]))
        gravity = float(np.linalg.norm(chain.gravity))
        mass = USUAL_SAG / (TYPICAL_COMPLIANCE * self.compliance) / max(gravity * reach, 1e-3)
        return mass, mass * reach / chain.n_joints

    def typical(self, effect: Effect, place: Place, symbol: str, shape: Values = NO_SHAPE) -> float:
        """Return the typical size of an amplitude on this robot, in its own unit (rigidities: of the inverse).

        What bends a spring's curve is as large as the joint's own spring; all else is as soft as the robot.
        """
        spec = effect.spec(symbol)
        unit = spec.unit
        order = {"²": 2, "³": 3}.get(unit[-1:], 1)
        own, torque = self.compliance, 1.0
        if place.joints:
            own, torque = float(self.of_joint[place.joints[0] - 1]), float(self.torque[place.joints[0] - 1])
        if unit.startswith("N·m/rad") and order > 1:
            compliance, torque = own * TYPICAL_COMPLIANCE, torque * TYPICAL_TORQUE
            return float(BEND / compliance**order / torque ** (order - 1))
        size = abs(spec.amplitude_of(spec.typical)) or 1.0
        if "N" not in unit or unit.startswith("N/") or unit == "N·m":
            return size
        if unit.startswith("rad/(N·m)") and order > 1:
            return float(size * own / torque ** (order - 1))
        return size * self.compliance


def _compliance(placed: PlacedEffect) -> float:
    """Return the compliance of a joint's drive, rad/(N·m), by a spring or a form that holds one; 0 of what has none."""
    if placed.effect.name == JOINT_SPRING:
        return placed.amplitude("c")
    symbol = spring_symbol(placed)
    rigidity = placed.values.get(symbol, 0.0) if symbol is not None else 0.0
    return 1.0 / rigidity if rigidity > 0.0 else 0.0
