"""How large effects of a moving joint usually are: as the catalogue says, for its friction and its speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from stiffcal.judgement.numbers import TYPICAL_FRICTION, TYPICAL_SPEED
from stiffcal.judgement.priors import NO_SHAPE
from stiffcal.kinds.row_search import RowProblem, UsualMotion
from stiffcal.model.effect import Effect, Place, Values


@dataclass(frozen=True)
class MotionSizes:
    """How joints move and resist, against those of the catalogue's typical sizes."""

    of_joints: Mapping[int, UsualMotion]
    """By joint, from 1."""

    @classmethod
    def of(cls, problem: RowProblem) -> Self:
        """Return it for the joints of a problem."""
        return cls({joint: problem.usual(joint) for joint in problem.joints})

    def typical(self, effect: Effect, place: Place, symbol: str, shape: Values = NO_SHAPE) -> float:
        """Return the typical size of an amplitude of this joint, in its own unit.

        It makes the share of the joint's friction, at the joint's speed, that the catalogue's makes of a typical one's.
        """
        spec = effect.spec(symbol)
        size, joint = abs(spec.typical) or 1.0, self.of_joints[place.joints[0]]
        if not spec.unit.startswith("N·m"):
            return size
        size *= joint.torque / TYPICAL_FRICTION
        if "s/rad" not in spec.unit and "s/(rad" not in spec.unit:
            return size
        powers = [name for name in shape if f"^{name}" in spec.unit]
        usual, own = (effect.spec(powers[0]).typical, shape[powers[0]]) if powers else (1.0, 1.0)
        return float(size * TYPICAL_SPEED**usual / joint.speed**own)
